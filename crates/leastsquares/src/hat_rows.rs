//! The hat matrix of solved blocks, factored, eight blocks side by side.
//!
//! With the whitened rows `[A | B]` of a block and the factors `R⁻¹`, `Z`, `Σ` of the covariance
//! ([`Covariance`]):
//!
//! ```text
//! J Q Jᵀ = [same block] O Oᵀ + T Σ Tᵀ      O = A R⁻¹      T = B - A Z
//! ```
//!
//! so what needs the hat matrix (redundancy, tests of single rows, variance components) is linear in the
//! number of rows.

use crate::block_batch::{BlockBatch, Shape};
use crate::covariance::Covariance;
use crate::lane_products::{LaneMatrix, add_product, subtract_product};
use crate::lanes::{Lanes, side_by_side, zeros};

/// `O`, `T` and the residuals of eight blocks, and memory to make them.
#[derive(Debug, Clone, Default)]
pub struct HatRows {
    /// Columns of `O`, and of `T`.
    unknowns: usize,
    width: usize,
    own: Vec<Lanes>,
    shared: Vec<Lanes>,
    residual: Vec<Lanes>,
    /// `A`, rows contiguous.
    rows: Vec<Lanes>,
    /// `R⁻¹`, columns contiguous, and `Z`, rows contiguous.
    inverse_factor: Vec<Lanes>,
    coupling: Vec<Lanes>,
}

impl HatRows {
    /// Takes the rows of the first `used` blocks of a batch, which is not eliminated yet; they are numbered
    /// from `first` in the covariance. Lanes from `used` on have rows of zeros: the batch must have been told
    /// so, too ([`BlockBatch::use_only`]).
    #[inline(always)]
    pub fn fill(
        &mut self,
        batch: &BlockBatch,
        covariance: &Covariance,
        (first, used): (usize, usize),
    ) {
        let Shape { rows, unknowns, .. } = batch.shape();
        (self.unknowns, self.width) = (unknowns, covariance.width());
        self.take_factors(covariance, (first, used));
        let mask = Lanes::mask(used);
        self.rows.clear();
        self.residual.clear();
        for row in 0..rows {
            self.rows
                .extend(batch.own_row(row).iter().map(|x| *x * mask));
            self.residual.push(batch.residual(row));
        }
        let a = LaneMatrix::by_rows(&self.rows, [rows, unknowns]);
        zeros(&mut self.own, rows * unknowns);
        let inverse_factor = LaneMatrix::by_columns(&self.inverse_factor, [unknowns; 2]);
        add_product(&mut self.own, a, inverse_factor);
        zeros(&mut self.shared, rows * self.width);
        for (i, row) in self.shared.chunks_exact_mut(self.width.max(1)).enumerate() {
            batch.copy_shared_row(i, row);
        }
        let coupling = LaneMatrix::by_rows(&self.coupling, [unknowns, self.width]);
        subtract_product(&mut self.shared, a, coupling);
    }

    /// Takes the covariance factors of `used` blocks from `first` on; lanes behind them repeat the last one.
    #[inline(always)]
    fn take_factors(&mut self, covariance: &Covariance, (first, used): (usize, usize)) {
        let block = |lane: usize| first + lane.min(used - 1);
        let columns = |lane| covariance.inverse_factor_columns(block(lane));
        let rows = |lane| covariance.coupling_rows(block(lane));
        let n = self.unknowns;
        side_by_side(columns, n * n, &mut self.inverse_factor);
        side_by_side(rows, n * self.width, &mut self.coupling);
    }

    /// `O`: one column for each unknown of the blocks.
    #[inline(always)]
    pub fn own(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.own, [self.residual.len(), self.unknowns])
    }

    /// `T`: one column for each shared unknown and datum multiplier.
    #[inline(always)]
    pub fn shared(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.shared, [self.residual.len(), self.width])
    }

    /// `R⁻¹` of the blocks ([`Covariance`]): upper triangular; lanes without a block repeat the last.
    #[inline(always)]
    pub fn inverse_factor(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_columns(&self.inverse_factor, [self.unknowns; 2])
    }

    /// `Z` of the blocks: one column for each shared unknown and datum multiplier.
    #[inline(always)]
    pub fn coupling(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.coupling, [self.unknowns, self.width])
    }

    /// The whitened residuals, observed minus computed.
    #[inline(always)]
    pub fn residual(&self) -> &[Lanes] {
        &self.residual
    }
}
