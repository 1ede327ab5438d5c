//! The reference frame from two average lines (paper 4.2.1).

use nalgebra::{Matrix3, Rotation3, Unit, UnitQuaternion, Vector3};

use crate::Error;

/// Lines closer than this (sine of the angle) do not span a plane: what turns the second by an
/// angle turns the plane by ten times as much.
const PARALLEL_TOL: f64 = 0.1;

/// The rotation `ref_from_measured` of the paper's reference frame: x along the average line of the X
/// slide, y in the plane of the average lines of X and Y, z = x × y.
///
/// Both lines have the sense of the positive motion of their axis; what keeps the second from the y
/// axis is its squareness. Calibration applies the same rule to machines of any kind; this is the
/// paper's own, for lines that are known.
///
/// # Errors
/// [`Error::Parallel`] if the lines make less than 5.7 degrees.
pub fn frame_from_lines(
    x_line: Unit<Vector3<f64>>,
    y_line: Unit<Vector3<f64>>,
) -> Result<UnitQuaternion<f64>, Error> {
    let normal = x_line.cross(&y_line);
    let sine = normal.norm();
    if sine.is_nan() || sine <= PARALLEL_TOL {
        return Err(Error::Parallel {
            angle_deg: sine.atan2(x_line.dot(&y_line).abs()).to_degrees(),
            limit_deg: PARALLEL_TOL.asin().to_degrees(),
        });
    }
    let z = normal / sine;
    let measured_from_ref = Matrix3::from_columns(&[x_line.into_inner(), z.cross(&x_line), z]);
    let rotation = Rotation3::from_matrix_unchecked(measured_from_ref.transpose());
    Ok(UnitQuaternion::from_rotation_matrix(&rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn x_line_is_x_and_y_line_lies_in_the_xy_plane() {
        let measured_from_ref = UnitQuaternion::from_euler_angles(0.3, -2.0, 1.1);
        let c0y = 1e-4_f64;
        let lines = [Vector3::x(), Vector3::new(-c0y.sin(), c0y.cos(), 0.0)];
        let [x, y] = lines.map(|line| Unit::new_normalize(measured_from_ref * line));
        let found = frame_from_lines(x, y).unwrap();
        assert!(found.angle_to(&measured_from_ref.inverse()) < 1e-14);
    }

    #[test]
    fn nearly_parallel_lines_are_refused_with_their_angle() {
        let almost = Unit::new_normalize(Vector3::new(-1.0, 0.05, 0.0));
        let refused = frame_from_lines(Vector3::x_axis(), almost);
        let Err(Error::Parallel { angle_deg, .. }) = refused else {
            panic!("accepted {refused:?}");
        };
        assert!((angle_deg - 0.05_f64.atan().to_degrees()).abs() < 1e-12);
    }
}
