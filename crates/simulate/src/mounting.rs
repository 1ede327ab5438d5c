//! Mounting errors that would move the reference frame.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Target;
use trueaxis_kinematics::{FrameRule, SmallMotion};

use crate::{Error, Problem};

/// Decimal mounting errors sum to zero within rounding, far below the 1e-7 mm of a length.
const MEAN_TOL_MM: f64 = 1e-9;

/// Over a metre this is a picometre, below the rounding of a length.
const ROTATION_TOL_RAD: f64 = 1e-12;

/// Corrected mounting errors are offered with twelve decimals: enough for both tolerances.
const MENDED_PER_MM: f64 = 1e12;

/// Refuses mounting errors whose rigid part belongs to the reference frame: the mean of those of
/// the targets that anchor it, and their best-fit rotation as far as no lines fix it.
pub(crate) fn check_mounting(
    frame: &FrameRule,
    targets: &[Target],
    homes_mm: &[Point3<f64>],
) -> Result<(), Error> {
    let anchors: Vec<&Target> = frame.anchors().map(|target| &targets[target]).collect();
    let shifts = frame.anchors();
    let shifts = shifts.map(|target| homes_mm[target] - targets[target].home_mm);
    let shifts: Vec<Vector3<f64>> = shifts.collect();
    // A scenario has no tilts of these lines but the one that leaves the frame alone.
    let tilts = vec![Vector3::zeros(); frame.lines().count()];
    let rigid = frame.motion(&tilts, &shifts);
    let names: Vec<&str> = anchors.iter().map(|target| target.name.as_str()).collect();
    let targets = names.join(", ");
    let corrected = corrected(&anchors, &shifts, &rigid);
    let problem = if rigid.translation.amax() > MEAN_TOL_MM {
        Problem::MountingMean {
            targets,
            mean_mm: rigid.translation.into(),
            corrected,
        }
    } else if rigid.rotation.amax() > ROTATION_TOL_RAD {
        Problem::MountingRotation {
            targets,
            rotation_rad: rigid.rotation.into(),
            corrected,
        }
    } else {
        return Ok(());
    };
    Err(problem.at("targets"))
}

/// The mounting errors without the motion that belongs to the frame.
fn corrected(anchors: &[&Target], mounting_mm: &[Vector3<f64>], rigid: &SmallMotion) -> String {
    let mounted = anchors.iter().zip(mounting_mm);
    let corrected = mounted.map(|(target, mounting_mm)| {
        let left = mounting_mm - rigid.at(target.home_mm);
        let m = left.map(|c| (c * MENDED_PER_MM).round() / MENDED_PER_MM + 0.0);
        format!("{} [{}, {}, {}]", target.name, m.x, m.y, m.z)
    });
    corrected.collect::<Vec<_>>().join(", ")
}
