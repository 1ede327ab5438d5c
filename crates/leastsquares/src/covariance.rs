//! Covariance of all unknowns from the factors of the arrowhead system.
//!
//! ```text
//! cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ    D = R⁻¹R⁻ᵀ
//! cov(x_i, s)   = -Z_i Σ_s                    Σ: inverse of the reduced matrix
//! ```

use nalgebra::{DMatrix, DMatrixView, Dyn, U1};

use crate::factors::Factors;
use crate::reduced::ReducedSolution;

/// Covariance of all unknowns for unit variance of the whitened rows, kept as factors: its size is
/// linear in the number of blocks.
#[derive(Debug, Clone)]
pub struct Covariance {
    shared: usize,
    factors: Factors,
    reduced_inverse: DMatrix<f64>,
}

impl Covariance {
    /// The covariance from the factors of all blocks and the solution of the reduced system.
    pub fn new(factors: Factors, solution: ReducedSolution) -> Self {
        Self {
            shared: solution.shared,
            factors,
            reduced_inverse: solution.inverse,
        }
    }

    /// `Σ`: symmetric matrix of the shared unknowns and, behind them, the datum multipliers. Its
    /// leading part is the covariance of the shared unknowns; the whole of it is indefinite and
    /// makes sense only between couplings.
    pub fn reduced_inverse(&self) -> &DMatrix<f64> {
        &self.reduced_inverse
    }

    /// Rows and columns of `Σ`: the number of shared unknowns and datum multipliers.
    pub fn width(&self) -> usize {
        self.factors.width()
    }

    /// Covariance of the shared unknowns.
    pub fn shared(&self) -> DMatrixView<'_, f64, U1, Dyn> {
        self.reduced_inverse
            .view((0, 0), (self.shared, self.shared))
    }

    /// `R⁻¹` of block `i`: upper triangular; the block's covariance with all shared unknowns held
    /// is `R⁻¹R⁻ᵀ`.
    pub fn inverse_factor(&self, i: usize) -> DMatrixView<'_, f64> {
        let n = self.factors.unknowns(i);
        DMatrixView::from_slice(self.factors.inverse_factor(i), n, n)
    }

    /// `Zᵀ` of block `i`: one row for each shared unknown and datum multiplier.
    pub fn coupling_transposed(&self, i: usize) -> DMatrixView<'_, f64> {
        DMatrixView::from_slice(
            self.factors.coupling(i),
            self.width(),
            self.factors.unknowns(i),
        )
    }

    /// The columns of `R⁻¹` of block `i`, one after the other.
    pub(crate) fn inverse_factor_columns(&self, i: usize) -> &[f64] {
        self.factors.inverse_factor(i)
    }

    /// The rows of `Z` of block `i`, one after the other.
    pub(crate) fn coupling_rows(&self, i: usize) -> &[f64] {
        self.factors.coupling(i)
    }

    /// Covariance of block `i`.
    pub fn block(&self, i: usize) -> DMatrix<f64> {
        let factor = self.inverse_factor(i);
        factor * factor.transpose() + self.between(i, i)
    }

    /// The part of the covariance between blocks `i` and `k` that comes through the shared
    /// unknowns; for `i ≠ k` it is the whole.
    pub fn between(&self, i: usize, k: usize) -> DMatrix<f64> {
        let left = self.coupling_transposed(i).tr_mul(&self.reduced_inverse);
        left * self.coupling_transposed(k)
    }
}
