//! The paper's own angles, for comparison with its tables.
//!
//! The paper draws every line as `x/m = y/n = z/1`, which cannot hold a line perpendicular to z,
//! as X and Y are. Unit vectors give what its Eq. 23 intends. Some of its angles have the opposite
//! sign of the right-hand rule and of [`squareness`](crate::squareness()):
//!
//! | paper | formula | equals |
//! | --- | --- | --- |
//! | θxy | 90° - arccos(x·y) | -C0Y, exactly |
//! | θxz | arctan(cos α / √(1 - cos²α - cos²β)) | +B0Z |
//! | θyz | arctan(cos β / √(1 - cos²α - cos²β)) | -A0Z |
//! | `SxC` | arctan(B / C) | -A0C |
//! | `SyC` | arctan(A / C) | +B0C |
//!
//! with cos α = x·z, cos β = y·z, and (A, B, C) the direction of the axis of rotation. The last
//! four hold to the first order of the angles; β is measured from the average Y line, so that θyz
//! takes up the product of `C0Y` and `B0Z`, too.

use nalgebra::{Unit, Vector3};

use crate::Error;

/// θxy, θxz, θyz of the paper's Eq. 23.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperSquareness {
    /// θxy = -C0Y.
    pub theta_xy_rad: f64,
    /// θxz = +B0Z.
    pub theta_xz_rad: f64,
    /// θyz = -A0Z.
    pub theta_yz_rad: f64,
}

/// Eq. 23 for the average lines of X, Y and Z, in any one frame.
///
/// # Errors
/// [`Error::PaperAngles`] if the Z line is so far from perpendicular to both others that the root
/// in Eq. 23 is not real and positive.
pub fn paper_squareness(
    x: Unit<Vector3<f64>>,
    y: Unit<Vector3<f64>>,
    z: Unit<Vector3<f64>>,
) -> Result<PaperSquareness, Error> {
    let (cos_alpha, cos_beta) = (x.dot(&z), y.dot(&z));
    let sum = cos_alpha * cos_alpha + cos_beta * cos_beta;
    if sum.is_nan() || sum >= 1.0 {
        return Err(Error::PaperAngles { sum });
    }
    let cos_gamma = (1.0 - sum).sqrt();
    Ok(PaperSquareness {
        // 90° - arccos u without the rounding of arccos near 90°.
        theta_xy_rad: x.dot(&y).clamp(-1.0, 1.0).asin(),
        theta_xz_rad: (cos_alpha / cos_gamma).atan(),
        theta_yz_rad: (cos_beta / cos_gamma).atan(),
    })
}

/// Angular location errors of a C axis as the paper defines them (4.2.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperTilt {
    /// `SxC` = arctan(B / C) = -A0C.
    pub s_xc_rad: f64,
    /// `SyC` = arctan(A / C) = +B0C.
    pub s_yc_rad: f64,
}

/// The paper's tilts of a C axis from its direction (A, B, C) in the reference frame; the same
/// for both senses of the direction. As C goes to zero they go to ±90 degrees, not to an error.
pub fn paper_c_axis_tilt(direction: Unit<Vector3<f64>>) -> PaperTilt {
    let [a, b, c] = [direction.x, direction.y, direction.z];
    let upright = if c < 0.0 { -1.0 } else { 1.0 };
    PaperTilt {
        s_xc_rad: (b * upright).atan2(c.abs()),
        s_yc_rad: (a * upright).atan2(c.abs()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::squareness;
    use nalgebra::UnitQuaternion;

    fn turned(direction: Vector3<f64>, tilt: Vector3<f64>) -> Unit<Vector3<f64>> {
        Unit::new_normalize(UnitQuaternion::from_scaled_axis(tilt) * direction)
    }

    /// Each of the three alone, at an angle where a wrong sign or factor would show: the relation is then exact,
    /// because Eq. 23 measures the angle of a line that stays in one plane.
    #[test]
    fn each_angle_alone_is_exact_up_to_its_sign() {
        let angle = 0.1;
        let (x, y, z) = (Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis());
        let c0y = turned(Vector3::y(), Vector3::z() * angle);
        let b0z = turned(Vector3::z(), Vector3::y() * angle);
        let a0z = turned(Vector3::z(), Vector3::x() * angle);
        let cases = [
            (paper_squareness(x, c0y, z), [-angle, 0.0, 0.0]),
            (paper_squareness(x, y, b0z), [0.0, angle, 0.0]),
            (paper_squareness(x, y, a0z), [0.0, 0.0, -angle]),
        ];
        for (found, expected) in cases {
            let found = found.unwrap();
            let found = [found.theta_xy_rad, found.theta_xz_rad, found.theta_yz_rad];
            for (f, e) in found.into_iter().zip(expected) {
                assert!((f - e).abs() < 1e-15, "{found:?} is not {expected:?}");
            }
        }
    }

    /// All together and in a turned frame: the signs hold to first order. The difference is of second order (and not
    /// zero, so the test does not compare a thing with itself).
    #[test]
    fn together_they_agree_to_first_order() {
        for size in [1e-3, 1e-4, 1e-5] {
            let [c0y, b0z, a0z] = [3.0 * size, -2.0 * size, 4.0 * size];
            let y = turned(Vector3::y(), Vector3::new(0.0, 0.0, c0y));
            let z = turned(Vector3::z(), Vector3::new(a0z, b0z, 0.0));
            assert!((squareness(Vector3::y_axis(), y).z - c0y).abs() < 1e-15);
            let of_z = squareness(Vector3::z_axis(), z);
            assert!((of_z - Vector3::new(a0z, b0z, 0.0)).norm() < 1e-15);

            let frame = UnitQuaternion::from_euler_angles(0.4, 1.3, -0.7);
            let found = paper_squareness(frame * Vector3::x_axis(), frame * y, frame * z).unwrap();
            assert!((found.theta_xy_rad + c0y).abs() < 1e-15);
            assert!((found.theta_xz_rad - b0z).abs() < 100.0 * size.powi(3) + 1e-15);
            // cos β = y·z = -A0Z - C0Y B0Z + third order.
            let second_order = found.theta_yz_rad + a0z;
            assert!((second_order + c0y * b0z).abs() < 100.0 * size.powi(3) + 1e-15);
            assert!(second_order.abs() > size * size);
        }
    }

    #[test]
    fn rotary_tilts_have_opposite_and_same_sign() {
        let [a0c, b0c] = [2e-4, -3e-4];
        let direction = turned(Vector3::z(), Vector3::new(a0c, b0c, 0.0));
        let found = paper_c_axis_tilt(direction);
        assert!((found.s_xc_rad + a0c).abs() < 1e-10);
        assert!((found.s_yc_rad - b0c).abs() < 1e-10);
        assert_eq!(found, paper_c_axis_tilt(-direction));
    }

    /// X and Y at 45 degrees to each other, Z in their plane half way between.
    #[test]
    fn a_z_line_beside_both_others_is_refused() {
        let [y, z] = [
            Vector3::new(1.0, 1.0, 0.0),
            Vector3::new(2.0_f64.sqrt() + 1.0, 1.0, 0.0),
        ]
        .map(Unit::new_normalize);
        let refused = paper_squareness(Vector3::x_axis(), y, z);
        let expected = 2.0 * 22.5_f64.to_radians().cos().powi(2);
        let Err(Error::PaperAngles { sum }) = refused else {
            panic!("accepted {refused:?}");
        };
        assert!((sum - expected).abs() < 1e-15);
    }
}
