//! What the errors of one axis do to everything that it carries.
//!
//! To first order in the errors, for the motion of [`Axis::motion`] with the reference point `c` of
//! δ where it is now, the nominal direction `d` and rotation `R` about it:
//!
//! ```text
//! linear   v(c) = δ + q t × d                  ρ = ε
//! rotary   v(c) = δ + (I - R + d dᵀ) s         ρ = ε + (I - R) t
//! ```
//!
//! (`s` shift, `t` tilt of the axis; the part of the shift along the axis lifts the stage).

use nalgebra::{Matrix3, Matrix3xX};

use crate::{Axis, AxisKind, LocationError, MotionError, Twist};

/// Number of errors of an axis: δ, ε, shift and tilt.
pub const AXIS_ERRORS: usize = 12;

/// First of the three columns of δ.
pub const TRANSLATION: usize = 0;
/// Of ε.
pub const ROTATION: usize = 3;
/// Of the shift of the axis.
pub const SHIFT: usize = 6;
/// Of its tilt.
pub const TILT: usize = 9;

/// The error motion of an axis at a position, seen from its base: one column for each of its errors
/// (mm, rad).
pub fn axis_twist(
    axis: &Axis,
    position: f64,
    location: &LocationError,
    error: &MotionError,
) -> Twist {
    let identity = Matrix3::identity();
    let direction = axis.direction().into_inner();
    let mut displacement = Matrix3xX::zeros(AXIS_ERRORS);
    let mut rotation = Matrix3xX::zeros(AXIS_ERRORS);
    let set = |rows: &mut Matrix3xX<f64>, first: usize, block: Matrix3<f64>| {
        rows.fixed_columns_mut::<3>(first).copy_from(&block);
    };
    set(&mut displacement, TRANSLATION, identity);
    set(&mut rotation, ROTATION, identity);
    match axis.kind() {
        AxisKind::Linear => {
            let along = direction * position;
            set(&mut displacement, TILT, -along.cross_matrix());
        }
        AxisKind::Rotary => {
            let turn = axis
                .commanded_motion(position, &LocationError::default())
                .rotation;
            let left = identity - turn.to_rotation_matrix().into_inner();
            let lift = direction * direction.transpose();
            set(&mut displacement, SHIFT, left + lift);
            set(&mut rotation, TILT, left);
        }
    }
    let reference = axis.motion(position, location, error) * axis.reference_at_home_mm(location);
    Twist::about(reference, displacement, rotation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3, Vector6};

    /// Differences of the exact motion, for axes along a reference direction and oblique ones.
    #[test]
    fn agrees_with_differences_of_the_exact_motion() {
        const STEP: f64 = 1e-6;
        let oblique = Vector3::new(0.6, 0.0, 0.8);
        let about = Point3::new(50.0, 60.0, 70.0);
        let axes = [
            Axis::linear("Y", Vector3::y(), [0.0, 400.0]).unwrap(),
            Axis::linear("W", oblique, [0.0, 400.0]).unwrap(),
            Axis::rotary("C", Vector3::z(), [0.0, 6.0], about).unwrap(),
            Axis::rotary("D", oblique, [0.0, 6.0], about).unwrap(),
        ];
        let point = Point3::new(120.0, -80.0, 310.0);
        for axis in axes {
            let position = match axis.kind() {
                AxisKind::Linear => 130.0,
                AxisKind::Rotary => 1.1,
            };
            let moved = |errors: &[f64; AXIS_ERRORS]| {
                let vector = |first: usize| Vector3::from_column_slice(&errors[first..first + 3]);
                let location = LocationError {
                    offset_mm: vector(SHIFT),
                    tilt_rad: vector(TILT),
                };
                let error = MotionError::new(vector(TRANSLATION), vector(ROTATION));
                axis.motion(position, &location, &error) * point
            };
            let twist = axis_twist(
                &axis,
                position,
                &LocationError::default(),
                &MotionError::from_vector(&Vector6::zeros()),
            );
            let found = twist.at(moved(&[0.0; AXIS_ERRORS]));
            for column in 0..AXIS_ERRORS {
                // A tilt about the axis itself is none.
                let mut step = [0.0; AXIS_ERRORS];
                step[column] = STEP;
                if column >= TILT {
                    let d = axis.direction().into_inner();
                    let across = Vector3::ith(column - TILT, STEP);
                    let across = across - d * d.dot(&across);
                    step[TILT..].copy_from_slice(across.as_slice());
                }
                let back = step.map(|x| -x);
                let expected = (moved(&step) - moved(&back)) / (2.0 * STEP);
                let mut predicted = Vector3::zeros();
                for (i, x) in step.iter().enumerate() {
                    predicted += found.column(i) * (x / STEP);
                }
                let difference = (predicted - expected).norm();
                assert!(
                    difference < 1e-6,
                    "{} {column}: {difference:e}",
                    axis.name()
                );
            }
        }
    }
}
