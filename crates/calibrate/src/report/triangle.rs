//! The measured shape of the targets against the nominal one.

use nalgebra::Point3;

use crate::identify::context::Context;
use crate::result::calibration::TriangleSide;

/// Difference of a measured distance between targets from nominal that needs no notice, mm.
const TRIANGLE_TOL_MM: f64 = 0.01;

/// The same in standard deviations of the distance at one step.
const TRIANGLE_TOL_SIGMAS: f64 = 5.0;

/// Distances between the targets of each run that differ from nominal by more than measurement
/// explains.
pub(crate) fn triangle(
    context: &Context<'_>,
    mean_mm: &[Option<Point3<f64>>],
    point_variance_mm2: Option<f64>,
) -> Vec<TriangleSide> {
    let targets = &context.campaign.targets;
    let mut found: Vec<TriangleSide> = Vec::new();
    let sigma_mm = (2.0 * point_variance_mm2.unwrap_or(0.0)).sqrt();
    let limit_mm = TRIANGLE_TOL_MM.max(TRIANGLE_TOL_SIGMAS * sigma_mm);
    for axis in context.data {
        for run in &axis.runs {
            let seen = run.targets.iter();
            let seen = seen.filter_map(|&t| Some((&targets[t], mean_mm[t]?)));
            let seen: Vec<_> = seen.collect();
            for (i, (first, first_mm)) in seen.iter().enumerate() {
                for (second, second_mm) in &seen[i + 1..] {
                    let side = TriangleSide {
                        targets: [first, second].map(|target| target.name.clone()),
                        nominal_mm: (second.home_mm - first.home_mm).norm(),
                        measured_mm: (second_mm - first_mm).norm(),
                    };
                    let known = found.iter().any(|other| other.targets == side.targets);
                    if !known && (side.measured_mm - side.nominal_mm).abs() > limit_mm {
                        found.push(side);
                    }
                }
            }
        }
    }
    found
}
