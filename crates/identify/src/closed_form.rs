//! The paper's closed solution of ①②④⑥⑧⑨, with N as its only denominator.

use nalgebra::Vector3;
use trueaxis_kinematics::MotionError;

use crate::Error;
use crate::design::{Extent, GEOMETRY_TOL, require_finite};

/// Solves Px Py Qx Qz Ky Kz for the six component errors in closed form (paper Eqs. 11, 18, 22).
///
/// `r` holds the generalised coordinates of P, Q, K relative to the reference point of δ, mm;
/// `delta` their volumetric errors, mm. The same equations as
/// [`SixRows::PAPER`](crate::SixRows::PAPER), solved without a matrix.
///
/// Eq. 18 is the right one of the three printed forms: in Eq. 22 the first term of δz lacks its
/// factor `(x̂K - x̂P)/(ẑP - ẑK)`, and in Eq. 11 δx and δy are garbled. All three divide by
/// `ẑP - ẑK` and `ẑQ - ẑP`, which only follows from the order of elimination. The differences
/// Qx - Px, Ky - Py, Kz - Qz leave three equations in ε that Cramer's rule solves with the
/// determinant N alone, so that targets of equal z are no problem as long as N is not zero.
///
/// # Errors
/// [`Error::NearZeroN`] if N vanishes against the cube of the longest distance between targets
/// (which can happen with all coordinates different), [`Error::NotFinite`].
pub fn closed_form(r: &[Vector3<f64>; 3], delta: &[Vector3<f64>; 3]) -> Result<MotionError, Error> {
    require_finite("position", r)?;
    require_finite("volumetric error", delta)?;
    let [p, q, k] = r;
    let [delta_p, delta_q, delta_k] = delta;
    let (qp, kp, kq) = (q - p, k - p, k - q);

    // u = Qx - Px =            εy qp.z - εz qp.y
    // v = Ky - Py = -εx kp.z           + εz kp.x
    // w = Kz - Qz =  εx kq.y - εy kq.x
    let u = delta_q.x - delta_p.x;
    let v = delta_k.y - delta_p.y;
    let w = delta_k.z - delta_q.z;

    let n_mm3 = kq.x * qp.y * kp.z - kp.x * kq.y * qp.z;
    let scale_mm3 = Extent::of(r).length_mm.powi(3);
    if n_mm3.abs() <= GEOMETRY_TOL * scale_mm3 {
        return Err(Error::NearZeroN { n_mm3, scale_mm3 });
    }
    let rotation = Vector3::new(
        kp.x * kq.x * u + qp.y * kq.x * v + kp.x * qp.z * w,
        kp.x * kq.y * u + qp.y * kq.y * v + qp.y * kp.z * w,
        kq.x * kp.z * u + kq.y * qp.z * v + qp.z * kp.z * w,
    ) / -n_mm3;

    // Rows Px, Py, Qz.
    let translation = Vector3::new(
        delta_p.x - rotation.y * p.z + rotation.z * p.y,
        delta_p.y - rotation.z * p.x + rotation.x * p.z,
        delta_q.z - rotation.x * q.y + rotation.y * q.x,
    );
    Ok(MotionError::new(translation, rotation))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SixRows;

    const R: [Vector3<f64>; 3] = [
        Vector3::new(16.338, 452.716, 122.416),
        Vector3::new(157.086, 332.593, 324.879),
        Vector3::new(248.925, 603.0552, 412.4483),
    ];
    const DELTA: [Vector3<f64>; 3] = [
        Vector3::new(1.7e-3, -4.1e-3, 0.6e-3),
        Vector3::new(-2.9e-3, 3.3e-3, 5.2e-3),
        Vector3::new(4.4e-3, -0.8e-3, -3.7e-3),
    ];

    /// Eq. 18 term by term, with its removable denominators.
    fn as_printed(r: &[Vector3<f64>; 3], delta: &[Vector3<f64>; 3]) -> MotionError {
        let [p, q, k] = r;
        let [dp, dq, dk] = delta;
        let m = (dq.x - dp.x) * (k.x - q.x) * (p.z - k.z)
            + ((dp.y - dk.y) * (k.y - q.y) + (dk.z - dq.z) * (p.z - k.z)) * (q.z - p.z);
        let n = (k.x - q.x) * (p.y - q.y) * (p.z - k.z) - (k.x - p.x) * (k.y - q.y) * (q.z - p.z);
        let translation = Vector3::new(
            dp.x + m / n * (p.y - p.z * (q.y - p.y) / (q.z - p.z))
                - p.z * (dq.x - dp.x) / (q.z - p.z),
            dp.y - m / n * (p.x - p.z * (p.x - k.x) / (p.z - k.z))
                - p.z * (dp.y - dk.y) / (p.z - k.z),
            dq.z + m / n * (q.y * (k.x - p.x) / (p.z - k.z) - q.x * (p.y - q.y) / (q.z - p.z))
                - q.y * (dk.y - dp.y) / (p.z - k.z)
                + q.x * (dq.x - dp.x) / (q.z - p.z),
        );
        let rotation = Vector3::new(
            (dk.y - dp.y) / (p.z - k.z) + (p.x - k.x) / (p.z - k.z) * (m / n),
            (dq.x - dp.x) / (q.z - p.z) + (q.y - p.y) / (q.z - p.z) * (m / n),
            m / n,
        );
        MotionError::new(translation, rotation)
    }

    #[test]
    fn equals_the_printed_equation_18() {
        let found = closed_form(&R, &DELTA).unwrap();
        let printed = as_printed(&R, &DELTA);
        let translation = found.translation_mm - printed.translation_mm;
        let rotation = found.rotation_rad - printed.rotation_rad;
        assert!(translation.norm() < 1e-13 * printed.translation_mm.norm());
        assert!(rotation.norm() < 1e-13 * printed.rotation_rad.norm());
    }

    /// The printed form is 0/0 there.
    #[test]
    fn equal_heights_are_no_singularity() {
        let [p, q, k] = R;
        let (mut level_q, mut level_k) = (q, k);
        level_q.z = p.z;
        level_k.z = p.z;
        for r in [[p, level_q, k], [p, q, level_k]] {
            assert!(!as_printed(&r, &DELTA).translation_mm.norm().is_finite());
            let found = closed_form(&r, &DELTA).unwrap();
            let expected = SixRows::PAPER.operator(&r).unwrap().apply(&DELTA);
            let difference = found.to_vector() - expected.to_vector();
            assert!(difference.norm() < 1e-12 * expected.to_vector().norm());
        }
    }

    /// Three targets of one height see no rotation about z by these six rows: N is zero.
    #[test]
    fn three_equal_heights_are_refused() {
        let level = R.map(|r| Vector3::new(r.x, r.y, 7.0));
        assert!(matches!(
            closed_form(&level, &DELTA),
            Err(Error::NearZeroN { n_mm3, .. }) if n_mm3 == 0.0
        ));
        assert!(matches!(
            SixRows::PAPER.operator(&level),
            Err(Error::SingularRows { .. })
        ));
        assert!(crate::nine(&level).is_ok());
    }

    #[test]
    fn zero_n_with_all_coordinates_different_is_refused() {
        let p = Vector3::new(7.0, 11.0, 13.0);
        let r = [
            p,
            p + Vector3::new(40.0, 20.0, 10.0),
            p + Vector3::new(60.0, 40.0, 30.0),
        ];
        let refused = closed_form(&r, &DELTA);
        let longest_cubed = 6100.0_f64.powf(1.5);
        assert!(matches!(
            refused,
            Err(Error::NearZeroN { n_mm3, scale_mm3 })
                if n_mm3 == 0.0 && (scale_mm3 - longest_cubed).abs() < 1e-6
        ));
        assert!(matches!(
            SixRows::PAPER.operator(&r),
            Err(Error::SingularRows { rows: SixRows::PAPER, condition, .. }) if condition > 1e12
        ));
        assert!(crate::nine(&r).is_ok());
    }

    #[test]
    fn what_is_not_finite_is_refused_by_name() {
        let mut delta = DELTA;
        delta[2].y = f64::NAN;
        assert_eq!(
            closed_form(&R, &delta),
            Err(Error::NotFinite {
                quantity: "volumetric error",
                target: 2
            })
        );
    }
}
