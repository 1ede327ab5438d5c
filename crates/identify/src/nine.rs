//! All equations by least squares: the nine-equation method.

use nalgebra::{DMatrix, Vector3};

use crate::covariance::{cholesky, require_covariance};
use crate::rigid_factors::RigidFactors;
use crate::{Error, Operator};

/// Least squares over all 3T equations of the paper's Eq. 21 (Eq. 9 for a linear, Eq. 16 for a
/// rotary axis), all coordinates equally well known.
///
/// `r` holds the generalised coordinates of at least three targets relative to the reference
/// point of δ, mm.
///
/// # Errors
/// [`Error::TooFewTargets`], [`Error::NotFinite`], [`Error::Collinear`] if no target is farther
/// from the line through the farthest two than 1e-6 of their distance.
pub fn nine(r: &[Vector3<f64>]) -> Result<Operator, Error> {
    Ok(RigidFactors::new(r)?.plain(r))
}

/// Generalised least squares over all 3T equations, `P = (Aᵀ C⁻¹ A)⁻¹ Aᵀ C⁻¹`: the estimate of
/// least variance when C is the covariance of the points.
///
/// `covariance` is 3T x 3T, mm², targets in order, x y z within each. Only its shape matters, not its scale; errors
/// that move the targets as one rigid body do not matter.
///
/// # Errors
/// As [`nine`], and [`Error::CovarianceShape`], [`Error::CovarianceAsymmetric`],
/// [`Error::Covariance`].
pub fn nine_weighted(r: &[Vector3<f64>], covariance: &DMatrix<f64>) -> Result<Operator, Error> {
    require_covariance(covariance, 3 * r.len())?;
    cholesky(covariance, &covariance.diagonal())?;
    RigidFactors::new(r)?.weighted(r, covariance)
}
