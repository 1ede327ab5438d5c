//! The covariance factors of eight blocks side by side.

use crate::covariance::Covariance;
use crate::lane_products::LaneMatrix;
use crate::lanes::{LANES, Lanes, side_by_side};

/// `R⁻¹` and `Z` of eight blocks ([`Covariance`]).
#[derive(Debug, Clone, Default)]
pub struct CovarianceLanes {
    /// Unknowns of each block, and columns of `Z`.
    unknowns: usize,
    width: usize,
    /// Columns contiguous.
    inverse_factor: Vec<Lanes>,
    /// Rows contiguous.
    coupling: Vec<Lanes>,
}

impl CovarianceLanes {
    /// Takes `used` blocks from `first` on, which have as many unknowns each; lanes behind them repeat the
    /// last one.
    #[inline(always)]
    pub fn fill(&mut self, covariance: &Covariance, (first, used): (usize, usize)) {
        self.unknowns = covariance.inverse_factor(first).ncols();
        self.width = covariance.width();
        let block = |lane: usize| first + lane.min(used - 1);
        let mut columns: [&[f64]; LANES] = [&[]; LANES];
        for (lane, columns) in columns.iter_mut().enumerate() {
            *columns = covariance.inverse_factor_columns(block(lane));
        }
        let length = self.unknowns * self.unknowns;
        side_by_side(columns, length, &mut self.inverse_factor);
        let mut rows: [&[f64]; LANES] = [&[]; LANES];
        for (lane, rows) in rows.iter_mut().enumerate() {
            *rows = covariance.coupling_rows(block(lane));
        }
        side_by_side(rows, self.unknowns * self.width, &mut self.coupling);
    }

    /// `R⁻¹`: upper triangular.
    #[inline(always)]
    pub fn inverse_factor(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_columns(&self.inverse_factor, [self.unknowns; 2])
    }

    /// `Z`: one column for each shared unknown and datum multiplier.
    #[inline(always)]
    pub fn coupling(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.coupling, [self.unknowns, self.width])
    }
}
