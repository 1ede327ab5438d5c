//! Covariance of all unknowns from the factors of the arrowhead system.
//!
//! ```text
//! cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ    D = R⁻¹R⁻ᵀ
//! cov(x_i, s)   = -Z_i Σ_s                    Σ: inverse of the reduced matrix
//! ```

use faer::{Mat, MatRef};

use crate::factors::Factors;
use crate::reduced::ReducedSolution;

/// Covariance of all unknowns for unit variance of the whitened rows, kept as factors: its size is
/// linear in the number of blocks.
#[derive(Debug, Clone)]
pub struct Covariance {
    shared: usize,
    factors: Factors,
    /// The rows of `Σ`, one after the other.
    reduced_inverse: Vec<f64>,
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
    pub fn reduced_inverse(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.reduced_inverse, self.width(), self.width())
    }

    /// Rows and columns of `Σ`: the number of shared unknowns and datum multipliers.
    pub fn width(&self) -> usize {
        self.factors.width()
    }

    /// The rows of `Σ`, one after the other.
    pub fn reduced_inverse_rows(&self) -> &[f64] {
        &self.reduced_inverse
    }

    /// Covariance of the shared unknowns.
    pub fn shared(&self) -> MatRef<'_, f64> {
        self.reduced_inverse()
            .submatrix(0, 0, self.shared, self.shared)
    }

    /// `R⁻¹` of block `i`: upper triangular; the block's covariance with all shared unknowns held
    /// is `R⁻¹R⁻ᵀ`.
    pub fn inverse_factor(&self, i: usize) -> MatRef<'_, f64> {
        let n = self.size(i);
        MatRef::from_column_major_slice(self.factors.inverse_factor(i), n, n)
    }

    /// `Z` of block `i`: one column for each shared unknown and datum multiplier.
    pub fn coupling(&self, i: usize) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(self.factors.coupling(i), self.size(i), self.width())
    }

    /// The columns of `R⁻¹` of block `i`, one after the other.
    pub fn inverse_factor_columns(&self, i: usize) -> &[f64] {
        self.factors.inverse_factor(i)
    }

    /// The rows of `Z` of block `i`, one after the other.
    pub fn coupling_rows(&self, i: usize) -> &[f64] {
        self.factors.coupling(i)
    }

    /// Covariance of block `i`.
    pub fn block(&self, i: usize) -> Mat<f64> {
        let factor = self.inverse_factor(i);
        factor * factor.transpose() + self.between(i, i)
    }

    /// The part of the covariance between blocks `i` and `k` that comes through the shared
    /// unknowns; for `i ≠ k` it is the whole.
    pub fn between(&self, i: usize, k: usize) -> Mat<f64> {
        self.coupling(i) * self.reduced_inverse() * self.coupling(k).transpose()
    }

    fn size(&self, i: usize) -> usize {
        self.factors.range(i).len()
    }
}
