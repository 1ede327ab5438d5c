//! Tilt of an average line against its nominal direction (paper 4.2.2).

use nalgebra::{Unit, Vector3};

/// The rotation vector (rad) of the least rotation that turns `nominal` onto `average`: the
/// location errors `A0? B0? C0?` of the line.
///
/// Right-hand rule: the average Y line `(-sin s, cos s, 0)` has `C0Y = s`, to first order the
/// average Z line `(B0Z, -A0Z, 1)` has `A0Z` and `B0Z`. The part about the nominal direction
/// itself is zero. Both directions have the sense of positive motion, in the reference frame; opposite directions
/// give half a turn about some axis across them.
pub fn squareness(nominal: Unit<Vector3<f64>>, average: Unit<Vector3<f64>>) -> Vector3<f64> {
    let cross = nominal.cross(&average);
    let (sine, cosine) = (cross.norm(), nominal.dot(&average));
    if sine > 0.0 {
        cross * (sine.atan2(cosine) / sine)
    } else if cosine > 0.0 {
        Vector3::zeros()
    } else {
        let across = nominal.cross(&Vector3::ith(nominal.iamin(), 1.0));
        across.normalize() * std::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use trueaxis_kinematics::{Axis, LocationError};

    #[test]
    fn inverts_the_average_direction_of_kinematics() {
        let z = Axis::linear("Z", Vector3::z(), [0.0, 1.0]).unwrap();
        for tilt_rad in [
            Vector3::new(1e-4, -3e-5, 0.0),
            Vector3::new(0.4, 0.9, 0.0),
            Vector3::new(0.0, 0.0, 0.0),
            Vector3::new(1e-200, 0.0, 0.0),
        ] {
            let location = LocationError {
                tilt_rad,
                ..Default::default()
            };
            let found = squareness(z.direction(), z.average_direction(&location));
            assert!((found - tilt_rad).norm() < 1e-15, "{found} for {tilt_rad}");
        }
    }

    #[test]
    fn c0y_turns_y_about_positive_z() {
        let c0y = 2e-4_f64;
        let average = Unit::new_normalize(Vector3::new(-c0y.sin(), c0y.cos(), 0.0));
        let found = squareness(Vector3::y_axis(), average);
        assert!((found - Vector3::new(0.0, 0.0, c0y)).norm() < 1e-18);
    }

    #[test]
    fn opposite_directions_are_half_a_turn_apart() {
        let nominal = Unit::new_normalize(Vector3::new(1.0, -2.0, 3.0));
        let turn = UnitQuaternion::from_scaled_axis(squareness(nominal, -nominal));
        assert!((turn * nominal.into_inner() + nominal.into_inner()).norm() < 1e-15);
    }
}
