//! Location errors of a rotary axis: the measured axis against the nominal one (paper 4.2.3).
//!
//! ```text
//! offset = q + t n - c  with t such that  (q + t n - c)·n0 = 0
//! tilt   = the least rotation that turns n0 onto n
//! ```
//!
//! for the measured axis through `q` along `n` and the nominal one through `c` along `n0`.

use nalgebra::Matrix3;
use trueaxis_kinematics::{Axis, LocationError};

use crate::{Error, Line, squareness};

/// Largest angle to the nominal direction. Beyond it the measured axis is a different one, or runs the other way.
const MAX_TILT_DEG: f64 = 45.0;

/// Location errors of a measured axis of rotation (`X0? Y0? Z0?` in mm, `A0? B0? C0?` in rad).
///
/// The offset lies across the nominal axis, in the plane through its reference point: a tilted axis is
/// elsewhere at each height. A line has no position along itself, so the axial part (`Z0C` for a C axis)
/// is zero here and must come from elsewhere. The tilt is [`squareness`](crate::squareness()) of the two
/// directions. The result moves the nominal axis exactly onto the measured line.
///
/// # Errors
/// [`Error::FarFromNominal`] beyond 45 degrees.
pub fn axis_location(nominal: &Axis, measured: &Line) -> Result<LocationError, Error> {
    let (n0, n) = (nominal.direction(), measured.direction);
    let cosine = n0.dot(&n);
    let sine = n0.cross(&n).norm();
    let angle_deg = sine.atan2(cosine).to_degrees();
    if angle_deg.is_nan() || angle_deg > MAX_TILT_DEG {
        return Err(Error::FarFromNominal {
            angle_deg,
            limit_deg: MAX_TILT_DEG,
        });
    }
    // Along the measured line onto the plane across the nominal axis.
    let slide = Matrix3::identity() - n.into_inner() * n0.transpose() / n.dot(&n0);
    Ok(LocationError {
        offset_mm: slide * (measured.point_mm - nominal.reference_mm()),
        tilt_rad: squareness(n0, n),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};

    fn c_axis() -> Axis {
        let point_mm = Point3::new(50.0, 60.0, 70.0);
        Axis::rotary("C", Vector3::z(), [0.0, 6.3], point_mm).unwrap()
    }

    /// Any point of the average axis of `trueaxis-kinematics` gives its location errors back.
    #[test]
    fn inverts_the_average_axis_of_kinematics() {
        let c = c_axis();
        let location = LocationError {
            offset_mm: Vector3::new(0.1, -0.2, 0.0),
            tilt_rad: Vector3::new(1e-3, 2e-3, 0.0),
        };
        let direction = c.average_direction(&location);
        for height_mm in [-300.0, 0.0, 250.0] {
            let centre = c.reference_mm() + location.offset_mm;
            let measured = Line {
                point_mm: centre + direction.into_inner() * height_mm,
                direction,
            };
            let found = axis_location(&c, &measured).unwrap();
            assert!((found.offset_mm - location.offset_mm).norm() < 1e-13);
            assert!((found.tilt_rad - location.tilt_rad).norm() < 1e-15);
            assert!(
                found.offset_mm.z.abs() < 1e-14,
                "a line has no axial position"
            );
        }
    }

    #[test]
    fn refuses_an_axis_that_runs_the_other_way() {
        let reversed = Line {
            point_mm: Point3::origin(),
            direction: -Vector3::z_axis(),
        };
        let refused = axis_location(&c_axis(), &reversed);
        assert!(matches!(
            refused,
            Err(Error::FarFromNominal { angle_deg, .. }) if (angle_deg - 180.0).abs() < 1e-12
        ));
    }
}
