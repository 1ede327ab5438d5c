//! Covariance of all unknowns from the factors of the arrowhead system.
//!
//! ```text
//! cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ    D = R⁻¹R⁻ᵀ
//! cov(x_i, s)   = -Z_i Σ_s                    Σ: inverse of the reduced matrix
//! ```

use nalgebra::{DMatrix, DMatrixView, Dyn, U1};

use crate::factors::{BatchFactors, Factors};
use crate::lane_products::{LaneMatrix, SharedMatrix, add_product, add_symmetric_product};
use crate::lanes::Lanes;
use crate::reduced::ReducedSolution;

/// Covariance of all unknowns for unit variance of the whitened rows, kept as factors: its size is
/// linear in the number of blocks.
#[derive(Debug, Clone)]
pub struct Covariance {
    shared: usize,
    /// `R⁻¹` and `Z` of each block; the block's covariance with all shared unknowns held is `R⁻¹R⁻ᵀ`.
    pub factors: Factors,
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

    /// Covariance of the shared unknowns.
    pub fn shared(&self) -> DMatrixView<'_, f64, U1, Dyn> {
        self.reduced_inverse
            .view((0, 0), (self.shared, self.shared))
    }

    /// Covariance of block `i`.
    pub fn block(&self, i: usize) -> DMatrix<f64> {
        let batch = self.factors.batch_of(i);
        symmetric(batch, i, &self.upper_triangles(batch))
    }

    /// Covariance of each block, in order: at less cost than one by one.
    pub fn blocks(&self) -> impl Iterator<Item = DMatrix<f64>> + '_ {
        (0..self.factors.batches()).flat_map(|b| {
            let batch = self.factors.batch(b);
            let all = self.upper_triangles(batch);
            let blocks = self.factors.blocks(b);
            blocks.map(move |i| symmetric(batch, i, &all))
        })
    }

    /// The upper triangles (and some of the lower) of the covariances of the blocks of a batch, by rows.
    fn upper_triangles(&self, batch: BatchFactors<'_>) -> Vec<Lanes> {
        let BatchFactors {
            inverse_factor,
            coupling,
            ..
        } = batch;
        let (n, width) = (coupling.rows(), coupling.columns());
        let sigma = SharedMatrix::by_rows(self.reduced_inverse.as_slice(), [width; 2]);
        let mut through = vec![Lanes::ZERO; n * width];
        add_product(&mut through, coupling, sigma);
        let through = LaneMatrix::by_rows(&through, [n, width]);
        let mut all = vec![Lanes::ZERO; n * n];
        add_symmetric_product(&mut all, inverse_factor, inverse_factor.transposed());
        add_symmetric_product(&mut all, through, coupling.transposed());
        all
    }
}

/// The symmetric matrix of block `i` of a batch.
fn symmetric(batch: BatchFactors<'_>, i: usize, upper_triangles: &[Lanes]) -> DMatrix<f64> {
    let n = batch.inverse_factor.rows();
    let upper = LaneMatrix::by_rows(upper_triangles, [n; 2]);
    let mut matrix = DMatrix::zeros(n, n);
    for j in 0..n {
        for k in j..n {
            let element = batch.in_lane(i, upper.at(j, k));
            (matrix[(j, k)], matrix[(k, j)]) = (element, element);
        }
    }
    matrix
}
