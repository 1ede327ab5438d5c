//! Whether the points of a step move as one rigid body.

use nalgebra::{DMatrix, Vector3};
use trueaxis_kinematics::MICROMETRE;

use crate::covariance::require_covariance;
use crate::design::require_finite;
use crate::rigid_factors::RigidFactors;
use crate::{Error, Operator};

/// What a rigid motion does not explain of the volumetric errors of one step.
#[derive(Debug, Clone, PartialEq)]
pub struct RigidMisfit {
    /// `Δ_j - δ - ε × r_j` for each target, mm.
    pub residual_mm: Vec<Vector3<f64>>,
    /// Root mean square of all 3T residual components, µm.
    pub rms_um: f64,
    /// `vᵀ C⁻¹ v` of the generalised least squares residual v: follows χ² if the targets are
    /// rigid and C is right.
    pub chi_squared: f64,
    /// 3T - 6: the number of independent distances between targets for T = 3.
    pub degrees_of_freedom: usize,
}

/// Compares the volumetric errors of a step with the rigid motion that `operator` finds in them.
///
/// `delta` is the input of [`Operator::apply`], mm; `covariance` that of the points, 3T x 3T, mm². The residuals are
/// those of `operator`. χ² depends on the points alone: with `B` an orthonormal basis of what no rigid motion reaches
/// (`Bᵀ A = 0`),
///
/// ```text
/// χ² = (Bᵀ Δ)ᵀ (Bᵀ C B)⁻¹ (Bᵀ Δ)
/// ```
///
/// which equals `vᵀ C⁻¹ v` of [`crate::nine_weighted`] and stays defined where C is singular
/// because a rigid motion of the whole triangle is known exactly.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::CovarianceShape`], [`Error::CovarianceAsymmetric`],
/// [`Error::Covariance`] if `Bᵀ C B` is not positive definite.
///
/// # Panics
/// If `delta` does not have one vector for each target.
pub fn rigid_misfit(
    operator: &Operator,
    delta: &[Vector3<f64>],
    covariance: &DMatrix<f64>,
) -> Result<RigidMisfit, Error> {
    require_finite("volumetric error", delta)?;
    require_covariance(covariance, 3 * delta.len())?;
    let residual_mm = operator.residual_mm(delta);
    let sum_mm2: f64 = residual_mm.iter().map(Vector3::norm_squared).sum();
    let components = 3.0 * residual_mm.len() as f64;

    Ok(RigidMisfit {
        rms_um: (sum_mm2 / components).sqrt() / MICROMETRE,
        chi_squared: RigidFactors::new(operator.targets_mm())?.chi_squared(delta, covariance)?,
        degrees_of_freedom: 3 * residual_mm.len() - 6,
        residual_mm,
    })
}
