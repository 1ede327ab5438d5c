//! Mounting errors that would move the reference frame.

use nalgebra::{Matrix3, Vector3};
use trueaxis_kinematics::Machine;

use crate::Error;
use crate::frame::ReferenceFrame;
use crate::plan::PlannedTarget;

/// Decimal mounting errors sum to zero within rounding, far below the 1e-7 mm of a length.
const MEAN_TOL_MM: f64 = 1e-9;

/// Over a metre this is a picometre, below the rounding of a length.
const ROTATION_TOL_RAD: f64 = 1e-12;

/// Moment of inertia, relative to the greatest, below which the targets stand on the line about
/// which it is taken: they hold no rotation about it.
const INERTIA_TOL: f64 = 1e-12;

/// Mended mounting errors are offered with twelve decimals: enough for both tolerances.
const MENDED_PER_MM: f64 = 1e12;

/// Refuses mounting errors whose rigid part belongs to the reference frame: the mean of those of
/// the targets that the first linear axis moves (of all targets if none runs), and without two
/// linear runs also their best-fit rotation.
pub(crate) fn check_mounting(
    machine: &Machine,
    frame: &ReferenceFrame,
    targets: &[PlannedTarget],
) -> Result<(), Error> {
    let defines = |target: &&PlannedTarget| match frame.first() {
        None => true,
        Some(first) => machine.chain(target.carrier).contains(&first),
    };
    let targets: Vec<&PlannedTarget> = targets.iter().filter(defines).collect();
    let rigid = RigidPart::of(&targets);
    if rigid.mean_mm.amax() > MEAN_TOL_MM {
        return Err(Error::MountingMean {
            targets: names(&targets),
            mean_mm: rigid.mean_mm.into(),
            mended: rigid.mended(&targets, !frame.is_oriented_by_runs()),
        });
    }
    if !frame.is_oriented_by_runs() && rigid.rotation_rad.amax() > ROTATION_TOL_RAD {
        return Err(Error::MountingRotation {
            targets: names(&targets),
            rotation_rad: rigid.rotation_rad.into(),
            mended: rigid.mended(&targets, true),
        });
    }
    Ok(())
}

/// The rigid motion closest to the mounting errors: `mean + rotation × (nominal - centroid)`.
struct RigidPart {
    centroid_mm: Vector3<f64>,
    mean_mm: Vector3<f64>,
    rotation_rad: Vector3<f64>,
}

impl RigidPart {
    fn of(targets: &[&PlannedTarget]) -> Self {
        let count = targets
            .iter()
            .fold(0.0, |count, _| count + 1.0_f64)
            .max(1.0);
        let nominal = || targets.iter().map(|t| t.nominal_mm.coords);
        let centroid_mm = nominal().sum::<Vector3<f64>>() / count;
        let mean_mm = targets
            .iter()
            .map(|t| t.mounting_mm())
            .sum::<Vector3<f64>>()
            / count;

        // Σ (|r|² I - r rᵀ) ω = Σ r × m
        let (mut inertia, mut moment) = (Matrix3::zeros(), Vector3::zeros());
        for target in targets {
            let r = target.nominal_mm.coords - centroid_mm;
            inertia += Matrix3::identity() * r.norm_squared() - r * r.transpose();
            moment += r.cross(&(target.mounting_mm() - mean_mm));
        }
        let principal = inertia.symmetric_eigen();
        let greatest = principal.eigenvalues.amax();
        let axes = principal.eigenvectors.column_iter();
        let rotation_rad = axes
            .zip(&principal.eigenvalues)
            .filter(|&(_, &inertia)| inertia > INERTIA_TOL * greatest)
            .map(|(axis, inertia)| axis * (axis.dot(&moment) / inertia))
            .sum();
        Self {
            centroid_mm,
            mean_mm,
            rotation_rad,
        }
    }

    /// The mounting errors without the mean and, if asked for, the rotation.
    fn mended(&self, targets: &[&PlannedTarget], without_rotation: bool) -> String {
        let mended = targets.iter().map(|target| {
            let mut m = target.mounting_mm() - self.mean_mm;
            if without_rotation {
                let r = target.nominal_mm.coords - self.centroid_mm;
                m -= self.rotation_rad.cross(&r);
            }
            let m = m.map(|c| (c * MENDED_PER_MM).round() / MENDED_PER_MM + 0.0);
            format!("{} [{}, {}, {}]", target.name, m.x, m.y, m.z)
        });
        mended.collect::<Vec<_>>().join(", ")
    }
}

fn names(targets: &[&PlannedTarget]) -> String {
    let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
    names.join(", ")
}
