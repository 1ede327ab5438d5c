//! The second derivatives of a sum of squares, relative to those of the linearised residuals.
//!
//! In coordinates in which `JᵀJ` is the unit matrix, half the Hessian of `|r|²` is
//!
//! ```text
//! B = I + Σ_i r_i Kᵀ (∇²r_i) K,   K = D⁻¹ V Σ⁻¹,
//! ```
//!
//! the unit matrix less the effective residual curvature matrix of D. M. Bates and D. G. Watts,
//! Nonlinear regression analysis and its applications (1988), section 7.1. At a minimum it is
//! positive; `-K B⁻¹ Uᵀ r` is Newton's step. Gauss–Newton takes `B` for the unit matrix.

use nalgebra::DMatrix;

use super::decompositions::symmetric_eigen;
use super::linearised::{Linearised, norm};
use super::model::Model;
use crate::Error;

/// Second derivatives are differences of the Jacobian over steps that change the residuals by this
/// fraction of their norm. That is a small fraction of the standard uncertainties, and rounding
/// leaves an error of `ε / (1e-5 σ)`: 1e-3 at the least singular value σ that counts as determined.
const DIFFERENCE: f64 = 1e-5;

/// Newton's step at a point of full rank.
pub(super) struct Newton {
    /// Least eigenvalue of `B`.
    pub(super) curvature: f64,
    /// Length by which the step changes the residuals, `|B⁻¹ Uᵀ r|`.
    pub(super) offset: f64,
    /// Change of the unknowns.
    pub(super) step: Vec<f64>,
}

impl Newton {
    pub(super) fn leads_to_a_minimum(&self) -> bool {
        self.curvature > 0.0
    }

    /// Its curvature is not a number if the Jacobian is not finite beside this point.
    pub(super) fn at(model: &dyn Model, here: &Linearised) -> Result<Self, Error> {
        let singular_values = here.svd.singular_values();
        let unknowns = singular_values.len();
        let hessian = relative_hessian(model, here);
        if !hessian.iter().all(|x| x.is_finite()) {
            return Ok(Self {
                curvature: f64::NAN,
                offset: f64::NAN,
                step: Vec::new(),
            });
        }
        let eigen = symmetric_eigen(hessian)?;
        let (values, q) = (eigen.eigenvalues, eigen.eigenvectors);
        let along = |k: usize| -> f64 {
            let sum: f64 = (0..unknowns).map(|i| q[(i, k)] * here.components[i]).sum();
            -sum / values[k]
        };
        let along: Vec<f64> = (0..unknowns).map(along).collect();
        let components: Vec<f64> = (0..unknowns)
            .map(|i| {
                let sum: f64 = (0..unknowns).map(|k| q[(i, k)] * along[k]).sum();
                sum / singular_values[i]
            })
            .collect();
        Ok(Self {
            curvature: values.min(),
            offset: norm(&along),
            step: here.svd.unknowns(&components),
        })
    }
}

fn relative_hessian(model: &dyn Model, here: &Linearised) -> DMatrix<f64> {
    let singular_values = here.svd.singular_values();
    let unknowns = singular_values.len();
    let length = DIFFERENCE * norm(&here.residuals);
    if length <= 0.0 {
        return DMatrix::identity(unknowns, unknowns);
    }
    let mut curved = DMatrix::<f64>::zeros(unknowns, unknowns);
    for k in 0..unknowns {
        let mut components = vec![0.0; unknowns];
        components[k] = length / singular_values[k];
        let beside = model.jacobian(&here.moved(&here.svd.unknowns(&components)));
        let gradient: Vec<f64> = (0..unknowns)
            .map(|j| {
                let rows = here.residuals.iter().enumerate();
                rows.map(|(i, r)| r * (beside[(i, j)] - here.jacobian[(i, j)]))
                    .sum()
            })
            .collect();
        for (i, g) in here.svd.gradient_components(&gradient).iter().enumerate() {
            curved[(i, k)] = g / (singular_values[i] * length);
        }
    }
    DMatrix::from_fn(unknowns, unknowns, |i, k| {
        let unit = if i == k { 1.0 } else { 0.0 };
        unit + 0.5 * (curved[(i, k)] + curved[(k, i)])
    })
}
