//! The hat matrix of solved blocks, factored, eight blocks side by side.
//!
//! With the whitened rows `[A | B]` of a block and the factors `R⁻¹`, `Z`, `Σ` of the covariance
//! ([`crate::Covariance`]):
//!
//! ```text
//! J Q Jᵀ = [same block] O Oᵀ + T Σ Tᵀ      O = A R⁻¹      T = B - A Z
//! ```
//!
//! so what needs the hat matrix (redundancy, tests of single rows, variance components) is linear in the
//! number of rows.

use crate::block_batch::{BlockBatch, Shape};
use crate::factors::BatchFactors;
use crate::lane_products::{LaneMatrix, add_product, subtract_product};
use crate::lanes::{Lanes, zeros};

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
}

impl HatRows {
    /// Takes the rows of the first `used` blocks of a batch, which is not eliminated yet, with their factors, finite in all lanes. Lanes from
    /// `used` on have rows of zeros: the batch must have been told so, too ([`BlockBatch::use_only`]).
    #[inline(always)]
    pub fn fill(&mut self, batch: &BlockBatch, factors: BatchFactors<'_>, used: usize) {
        let Shape { rows, unknowns, .. } = batch.shape();
        let coupling = factors.coupling;
        (self.unknowns, self.width) = (unknowns, coupling.columns());
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
        add_product(&mut self.own, a, factors.inverse_factor);
        zeros(&mut self.shared, rows * self.width);
        for (i, row) in self.shared.chunks_exact_mut(self.width.max(1)).enumerate() {
            batch.copy_shared_row(i, row);
        }
        subtract_product(&mut self.shared, a, coupling);
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

    /// The whitened residuals, observed minus computed.
    #[inline(always)]
    pub fn residual(&self) -> &[Lanes] {
        &self.residual
    }
}
