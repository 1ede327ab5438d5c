//! All equations by least squares: the nine-equation method.

use nalgebra::{DMatrix, Vector3};

use crate::covariance::{cholesky, require_covariance, whitening};
use crate::design::{CentredTargets, Extent};
use crate::distortion::Covariance9;
use crate::three_targets::ThreeTargets;
use crate::{Error, Operator};

/// Least squares over all 3T equations of Eq. 21, all coordinates equally well known.
///
/// `r` holds the generalised coordinates of at least three targets relative to the reference
/// point of δ, mm. For three of them the solution is a closed form; [`crate::nine_closed_form`]
/// applies it without an operator.
///
/// # Errors
/// [`Error::TooFewTargets`], [`Error::NotFinite`], [`Error::Collinear`] if no target is farther
/// from the line through the farthest two than 1e-6 of their distance.
pub fn nine(r: &[Vector3<f64>]) -> Result<Operator, Error> {
    if let Ok(three) = r.try_into() {
        let blocks = ThreeTargets::new(three)?.blocks();
        return Ok(Operator::from_blocks(r, blocks.into()));
    }
    whitened(r, DMatrix::identity(3 * r.len(), 3 * r.len()))
}

/// Generalised least squares over all 3T equations, `P = (Aᵀ C⁻¹ A)⁻¹ Aᵀ C⁻¹`: the estimate of
/// least variance when C is the covariance of the points.
///
/// `covariance` is 3T x 3T, mm², targets in order, x y z within each. Only its shape matters, not
/// its scale; errors that move the targets as one rigid body may be in it or not. For three targets
/// the solution is a closed form but for a 3 x 3 matrix.
///
/// # Errors
/// As [`nine`], and [`Error::CovarianceShape`], [`Error::CovarianceAsymmetric`],
/// [`Error::Covariance`].
pub fn nine_weighted(r: &[Vector3<f64>], covariance: &DMatrix<f64>) -> Result<Operator, Error> {
    let Ok(three) = <&[Vector3<f64>; 3]>::try_from(r) else {
        return whitened(r, whitening(covariance, 3 * r.len())?);
    };
    require_covariance(covariance, 9)?;
    let covariance = Covariance9::from_column_slice(covariance.as_slice());
    cholesky(&covariance, &covariance.diagonal())?;
    let blocks = ThreeTargets::new(three)?.weighted_blocks(&covariance)?;
    Ok(Operator::from_blocks(r, blocks.into()))
}

/// Least squares over `W A x = W Δ`: with `W A = Q R` the operator is `R⁻¹ Qᵀ W`.
pub(crate) fn whitened(r: &[Vector3<f64>], w: DMatrix<f64>) -> Result<Operator, Error> {
    let centred = CentredTargets::new(r)?;
    let qr = (&w * centred.equations()).qr();
    let mut qt_w = w;
    qr.q_tr_mul(&mut qt_w);
    let mut solution = qt_w.fixed_rows::<6>(0).into_owned();
    // Targets that are not collinear give a regular R; a zero on its diagonal says the same.
    let r_factor = qr.r().fixed_rows::<6>(0).into_owned();
    if !r_factor.solve_upper_triangular_mut(&mut solution) {
        return Err(Extent::of(r).collinear());
    }
    Ok(Operator::from_scaled(r, &centred, &solution))
}
