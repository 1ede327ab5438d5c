//! The six component errors of an axis at one position.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, Vector6};

/// The deviation of a stage from its ideal pose at one position of its axis: the paper's δ and ε.
///
/// Both are given along the axes of the reference frame. A positive rotation turns the stage
/// about the positive axis (right-hand rule).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionError {
    /// Displacement δ of the reference point of the stage, mm (`EX? EY? EZ?`).
    pub translation_mm: Vector3<f64>,
    /// Rotation vector ε of the stage, rad (`EA? EB? EC?`).
    pub rotation_rad: Vector3<f64>,
}

impl MotionError {
    /// The error with δ = `translation_mm` and ε = `rotation_rad`.
    pub fn new(translation_mm: Vector3<f64>, rotation_rad: Vector3<f64>) -> Self {
        Self {
            translation_mm,
            rotation_rad,
        }
    }

    /// Linear form `Δ = δ + ε × r` (paper Eqs. 1 to 4 and 20), mm.
    ///
    /// `r` is the position of the point relative to the reference point of δ; for a rotary axis
    /// it is turned by the commanded angle already (the generalised coordinates of Eq. 19,
    /// [`crate::Axis::commanded_motion`]).
    pub fn displacement_mm(&self, r: Vector3<f64>) -> Vector3<f64> {
        self.translation_mm + self.rotation_rad.cross(&r)
    }

    /// The exact rigid motion `r -> δ + exp(ε) r`, of which Eqs. 1 and 3 of the paper are the linear part; `exp` turns by
    /// `|ε|` about `ε`.
    ///
    /// It differs from [`MotionError::displacement_mm`] by at most `|ε|² |r| / 2`.
    pub fn isometry(&self) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::from(self.translation_mm),
            UnitQuaternion::from_scaled_axis(self.rotation_rad),
        )
    }

    /// δx δy δz (mm), εx εy εz (rad): the order of [`crate::Component::ALL`].
    pub fn to_vector(&self) -> Vector6<f64> {
        let (t, r) = (self.translation_mm, self.rotation_rad);
        Vector6::new(t.x, t.y, t.z, r.x, r.y, r.z)
    }

    /// The inverse of [`MotionError::to_vector`].
    pub fn from_vector(v: &Vector6<f64>) -> Self {
        Self::new(
            v.fixed_rows::<3>(0).into_owned(),
            v.fixed_rows::<3>(3).into_owned(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_rotation_about_z_moves_x_towards_y() {
        let yaw = MotionError::new(Vector3::zeros(), Vector3::new(0.0, 0.0, 1e-5));
        let moved = yaw.displacement_mm(Vector3::new(100.0, 0.0, 0.0));
        assert!((moved - Vector3::new(0.0, 1e-3, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn linear_form_is_the_first_order_of_the_exact_motion() {
        let error = MotionError::new(
            Vector3::new(0.01, -0.02, 0.03),
            Vector3::new(1e-4, -2e-4, 5e-5),
        );
        let r = Vector3::new(300.0, -200.0, 450.0);
        let exact = error.isometry().transform_vector(&r) + error.translation_mm - r;
        let second_order_mm = 0.5 * error.rotation_rad.norm_squared() * r.norm();
        let difference_mm = (exact - error.displacement_mm(r)).norm();
        assert!(difference_mm < 1.01 * second_order_mm);
        assert!(
            difference_mm > 0.1 * second_order_mm,
            "the exact form must not be the linear one"
        );
    }
}
