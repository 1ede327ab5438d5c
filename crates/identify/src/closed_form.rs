//! The paper's closed solution of ①②④⑥⑧⑨, with N as its only denominator.

use nalgebra::Vector3;
use trueaxis_kinematics::MotionError;

use crate::Error;
use crate::design::{Extent, GEOMETRY_TOL, require_finite};

/// Solves Px Py Qx Qz Ky Kz (paper Eqs. 10 and 17) for the six component errors in closed form
/// (Eqs. 11, 18 and 22).
///
/// `r` holds the generalised coordinates of P, Q, K relative to the reference point of δ, mm;
/// `delta` their volumetric errors, mm. The same equations as
/// [`SixRows::PAPER`](crate::SixRows::PAPER), solved without a matrix: a second opinion on the
/// operator that `--method six` uses.
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
