//! The measured shape of the targets against the nominal one.

use nalgebra::Point3;
use trueaxis_identify::triangle_mismatch;

use crate::identify::context::Context;
use crate::result::calibration::TriangleSide;

/// A measured distance between targets that differs less from nominal needs no word, mm.
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
    let variance_mm2 = point_variance_mm2.unwrap_or(0.0);
    for axis in context.data {
        for run in &axis.runs {
            let seen = run.targets.iter();
            let seen = seen.filter_map(|&t| Some((&targets[t], mean_mm[t]?)));
            let (seen, measured): (Vec<_>, Vec<_>) = seen.unzip();
            let nominal: Vec<_> = seen.iter().map(|target| target.home_mm).collect();
            let Ok(sides) = triangle_mismatch(&nominal, &measured) else {
                continue;
            };
            let limit_mm = TRIANGLE_TOL_MM.max(TRIANGLE_TOL_SIGMAS * (2.0 * variance_mm2).sqrt());
            for side in sides {
                let names = [side.first, side.second].map(|i| seen[i].name.clone());
                let known = found.iter().any(|other| other.targets == names);
                if !known && (side.measured_mm - side.nominal_mm).abs() > limit_mm {
                    found.push(TriangleSide {
                        targets: names,
                        nominal_mm: side.nominal_mm,
                        measured_mm: side.measured_mm,
                    });
                }
            }
        }
    }
    found
}
