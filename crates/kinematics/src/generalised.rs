//! The generalised coordinates of the paper's Eq. 19.

use nalgebra::{UnitQuaternion, Vector3};

use crate::{Axis, AxisKind};

/// Position `x̂ ŷ ẑ` of a stage point in the error model `Δ = δ + ε × r` (paper Eq. 19), mm.
///
/// `r_in_stage` is the point's position in the stage frame; `position` is the commanded position
/// (mm or rad). A linear axis leaves it as it is, a rotary axis turns it by the commanded angle
/// about its nominal direction.
pub fn generalised_coordinates(
    axis: &Axis,
    position: f64,
    r_in_stage: Vector3<f64>,
) -> Vector3<f64> {
    match axis.kind() {
        AxisKind::Linear => r_in_stage,
        AxisKind::Rotary => {
            UnitQuaternion::from_axis_angle(&axis.direction(), position) * r_in_stage
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Eq. 19a, 19b, 19c as printed.
    #[test]
    fn agrees_with_the_printed_equations() {
        let (x, y, z, angle) = (3.0, -5.0, 7.0, 0.7_f64);
        let (s, c) = angle.sin_cos();
        let printed = [
            (Vector3::x(), Vector3::new(x, y * c - z * s, z * c + y * s)),
            (Vector3::y(), Vector3::new(x * c + z * s, y, z * c - x * s)),
            (Vector3::z(), Vector3::new(x * c - y * s, y * c + x * s, z)),
        ];
        for (direction, expected) in printed {
            let axis = Axis::rotary("R", direction, [0.0, 6.0], Point3::origin()).unwrap();
            let found = generalised_coordinates(&axis, angle, Vector3::new(x, y, z));
            assert!((found - expected).norm() < 1e-14);
        }
    }
}
