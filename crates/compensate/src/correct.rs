//! The positions to command, so that the tool comes where it was meant to be.

use nalgebra::Point3;
use trueaxis_kinematics::{AxisKind, GeometricErrors, MICROMETRE, Machine, MotionError};

use crate::Error;
use crate::freedom::{Freedom, Moved};

/// The iteration ends when the next correction would be below 1e-6 µm, far below any error and far above the rounding
/// of positions.
const RESIDUAL_MM: f64 = 1e-6 * MICROMETRE;

/// Lever at which an angle counts as a displacement, mm: the size of a machine.
const LEVER_MM: f64 = 1000.0;

/// Largest ratio of two corrections that follow each other. Errors of machines change by 1e-4 of the way at most, so
/// that the ratio of a sound calibration is about 1e-4.
const MOST_CONTRACTION: f64 = 0.5;

/// Corrected positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrected {
    /// Positions of all axes to command, mm or rad.
    pub positions: Vec<f64>,
    /// What stays of the error of the tool against the workpiece: what no motion of the axes takes away (the rotation
    /// of the tool on a machine of three linear axes), mm and rad.
    pub left: MotionError,
    /// Number of corrections.
    pub iterations: usize,
    /// Largest ratio of two corrections that follow each other: below 1, so the result is the only one near.
    pub contraction: f64,
}

/// The positions of all axes that bring the tool where a machine without errors brings it at `commanded` (mm or rad in
/// the order of [`Machine::axes`]), as far as the axes that are moved can.
///
/// `tool_home_mm` is the tool point in the reference frame at home. Fixed-point iteration on the error that
/// [`Machine::tool_error`] defines,
///
/// ```text
/// q ← q - J⁺ e(q)      e(q): tool at q with errors against tool at `commanded` without
/// ```
///
/// with the Jacobian of the machine without errors. It contracts with the slope of the errors (S. Banach's theorem), which
/// is checked.
///
/// # Errors
/// [`Error::NotContracting`] if it does not.
///
/// # Panics
/// If `commanded` are fewer than the axes of the machine.
pub fn correct(
    machine: &Machine,
    errors: &impl GeometricErrors,
    commanded: &[f64],
    tool_home_mm: Point3<f64>,
    moved: Moved,
) -> Result<Corrected, Error> {
    let freedom = Freedom::new(machine, commanded, tool_home_mm, moved);
    let mut positions = commanded.to_vec();
    let (mut last_size, mut contraction) = (f64::INFINITY, 0.0_f64);
    let mut iterations = 0;
    loop {
        let left = machine.tool_error_at(errors, commanded, &positions, tool_home_mm);
        let correction = freedom.undoing(&left);
        let size = size_mm(machine, &correction);
        if size < RESIDUAL_MM {
            return Ok(Corrected {
                positions,
                left,
                iterations,
                contraction,
            });
        }
        contraction = contraction.max(size / last_size);
        // Also refuses what is not a number.
        if !(contraction <= MOST_CONTRACTION && size.is_finite()) {
            return Err(Error::NotContracting {
                positions: commanded.to_vec(),
                contraction,
                limit: MOST_CONTRACTION,
            });
        }
        last_size = size;
        iterations += 1;
        let pairs = positions.iter_mut().zip(correction);
        pairs.for_each(|(position, correction)| *position += correction);
    }
}

/// What [`correct`] adds to each commanded position where the linear axes alone are moved, mm or rad.
pub(crate) fn added(
    machine: &Machine,
    errors: &impl GeometricErrors,
    commanded: &[f64],
    tool_home_mm: Point3<f64>,
) -> Result<Vec<f64>, Error> {
    let corrected = correct(machine, errors, commanded, tool_home_mm, Moved::Linear)?;
    let pairs = corrected.positions.iter().zip(commanded);
    Ok(pairs.map(|(corrected, at)| corrected - at).collect())
}

/// By how much the axes deviate from where they were commanded to be, as far as the tool shows it: the displacements
/// of the axes that would make the same error of the tool, mm or rad. To first order the opposite of what
/// [`correct`] adds.
///
/// # Panics
/// As [`correct`].
pub fn axis_deviations(
    machine: &Machine,
    errors: &impl GeometricErrors,
    commanded: &[f64],
    tool_home_mm: Point3<f64>,
    moved: Moved,
) -> Vec<f64> {
    let error = machine.tool_error(errors, commanded, tool_home_mm);
    let undoing = Freedom::new(machine, commanded, tool_home_mm, moved).undoing(&error);
    undoing.into_iter().map(|by| -by).collect()
}

fn size_mm(machine: &Machine, correction: &[f64]) -> f64 {
    let axes = machine.axes().iter().zip(correction);
    let sizes = axes.map(|(axis, correction)| match axis.kind() {
        AxisKind::Linear => correction.abs(),
        AxisKind::Rotary => correction.abs() * LEVER_MM,
    });
    // Unlike `f64::max`, a sum keeps what is not a number.
    sizes.sum()
}
