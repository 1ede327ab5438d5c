//! Errors of the calibration drawn from its covariance.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use trueaxis_montecarlo::ChaCha8Rng;

use crate::calibrated_machine::CalibratedMachine;
use crate::pivoted_cholesky::pivoted_cholesky;

/// More results than this are not drawn: the root of their covariance would take longer than all else.
const MOST_RESULTS: usize = 3000;

/// Variances that are left below this part of a result's own are rounding.
const ROUNDING: f64 = 1e-12;

/// `R` with `cov = R Rᵀ`, for component and location errors; `None` if these are too many or not finite.
pub(crate) struct Root(DMatrix<f64>);

impl Root {
    pub(crate) fn new(machine: &CalibratedMachine) -> Option<Self> {
        let count = machine.values().len();
        if count > MOST_RESULTS {
            return None;
        }
        let dense = machine.factors.dense();
        if !dense.iter().all(|x| x.is_finite()) {
            return None;
        }
        // µm and ″ are of one size, mm and rad are not.
        let u: Vec<f64> = (0..count).map(|i| dense[(i, i)].max(0.0).sqrt()).collect();
        let correlation = DMatrix::from_fn(count, count, |i, j| {
            let product = u[i] * u[j];
            if product > 0.0 {
                dense[(i, j)] / product
            } else {
                0.0
            }
        });
        let columns = pivoted_cholesky(&correlation, ROUNDING);
        let root = DMatrix::from_fn(count, columns.len(), |i, j| u[i] * columns[j][i]);
        Some(Self(root))
    }

    /// Draw `number`: errors of all results, mm and rad; the same for the same seed.
    pub(crate) fn draw(&self, seed: u64, number: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number);
        let deviates = DVector::from_fn(self.0.ncols(), |_, _| rng.sample(StandardNormal));
        (&self.0 * deviates).as_slice().to_vec()
    }
}
