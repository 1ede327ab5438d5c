//! The reference frame from two average lines (paper 4.2.1).

use nalgebra::{
    Isometry3, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3,
};

use crate::Error;

/// A thing as it should be in the reference frame and as it was measured in the instrument's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observed<T> {
    /// Where it is in the reference frame.
    pub nominal: T,
    /// Where it was measured, in the frame of the instrument.
    pub measured: T,
}

/// Least angle between two lines that are to span a plane. At this angle the uncertainty of their
/// directions already turns the plane by 57 times as much.
const MIN_ANGLE_DEG: f64 = 1.0;

/// The rotation `ref_from_measured` that brings the first measured line exactly onto its nominal
/// direction and the second into the plane of the two nominal directions, on the nominal side.
///
/// For the average lines of X and Y that is the frame of the paper: x along the X line, y in the
/// plane of the X and Y lines, z = x × y. What keeps the second line from its nominal direction in
/// that plane is its squareness.
///
/// A measured direction has the sense of the axis' positive motion, as nominal. The sense of a
/// fitted line is that of the order of its points ([`crate::Line::reversed`] turns it).
///
/// # Errors
/// [`Error::Parallel`] if either pair of directions makes less than 1 degree.
pub fn frame_from_lines(
    first: Observed<Unit<Vector3<f64>>>,
    second: Observed<Unit<Vector3<f64>>>,
) -> Result<UnitQuaternion<f64>, Error> {
    let in_ref = triad("nominal", first.nominal, second.nominal)?;
    let in_measured = triad("measured", first.measured, second.measured)?;
    let rotation = Rotation3::from_matrix_unchecked(in_ref * in_measured.transpose());
    Ok(UnitQuaternion::from_rotation_matrix(&rotation))
}

/// `ref_from_measured` with a given rotation that brings a measured point (the stage origin at
/// home, or the centroid of the targets) to its nominal place; mm.
pub fn frame_through_point(
    rotation: UnitQuaternion<f64>,
    point_mm: Observed<Point3<f64>>,
) -> Isometry3<f64> {
    let shift = point_mm.nominal - rotation * point_mm.measured;
    Isometry3::from_parts(Translation3::from(shift), rotation)
}

/// Right-handed unit vectors in columns: along `first`, towards `second` in their plane, and
/// across both.
fn triad(
    which: &'static str,
    first: Unit<Vector3<f64>>,
    second: Unit<Vector3<f64>>,
) -> Result<Matrix3<f64>, Error> {
    let normal = first.cross(&second);
    let angle_deg = normal.norm().atan2(first.dot(&second).abs()).to_degrees();
    if angle_deg.is_nan() || angle_deg < MIN_ANGLE_DEG {
        return Err(Error::Parallel {
            which,
            angle_deg,
            limit_deg: MIN_ANGLE_DEG,
        });
    }
    let normal = normal.normalize();
    Ok(Matrix3::from_columns(&[
        first.into_inner(),
        normal.cross(&first),
        normal,
    ]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observed(nominal: Vector3<f64>, measured: Vector3<f64>) -> Observed<Unit<Vector3<f64>>> {
        Observed {
            nominal: Unit::new_normalize(nominal),
            measured: Unit::new_normalize(measured),
        }
    }

    #[test]
    fn x_line_is_x_and_y_line_lies_in_the_xy_plane() {
        let measured_from_ref = UnitQuaternion::from_euler_angles(0.3, -2.0, 1.1);
        let c0y = 1e-4_f64;
        let x_line = measured_from_ref * Vector3::x();
        let y_line = measured_from_ref * Vector3::new(-c0y.sin(), c0y.cos(), 0.0);
        let rotation = frame_from_lines(
            observed(Vector3::x(), x_line),
            observed(Vector3::y(), y_line),
        )
        .unwrap();
        assert!(rotation.angle_to(&measured_from_ref.inverse()) < 1e-14);

        let home = Observed {
            nominal: Point3::new(1.0, 2.0, 3.0),
            measured: Point3::new(-700.0, 20.0, 900.0),
        };
        let ref_from_measured = frame_through_point(rotation, home);
        assert!((ref_from_measured * home.measured - home.nominal).norm() < 1e-12);
    }

    #[test]
    fn directions_need_not_be_perpendicular() {
        let slanted = Vector3::new(1.0, 1.0, 0.0);
        let turn = UnitQuaternion::from_euler_angles(-1.0, 0.5, 3.0);
        let rotation = frame_from_lines(
            observed(Vector3::z(), turn * Vector3::z()),
            observed(slanted, turn * slanted),
        )
        .unwrap();
        assert!(rotation.angle_to(&turn.inverse()) < 1e-14);
    }

    #[test]
    fn parallel_lines_are_refused_with_their_angle() {
        let almost = Vector3::new(-1.0, 1e-3, 0.0);
        let refused = frame_from_lines(
            observed(Vector3::x(), Vector3::x()),
            observed(Vector3::y(), almost),
        );
        let Err(Error::Parallel {
            which: "measured",
            angle_deg,
            ..
        }) = refused
        else {
            panic!("accepted {refused:?}");
        };
        assert!((angle_deg - 1e-3_f64.to_degrees()).abs() < 1e-6);
    }
}
