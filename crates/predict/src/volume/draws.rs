//! Errors of the calibration drawn from its covariance.

use faer::Mat;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use trueaxis_leastsquares::dense::{SymmetricEigen, symmetric_eigen};
use trueaxis_montecarlo::ChaCha8Rng;

use crate::calibrated_machine::CalibratedMachine;

/// More results than this are not drawn: the eigenvalues of their covariance would take longer than all else.
const MOST_RESULTS: usize = 3000;

/// `R` with `cov = R Rᵀ`, for component and location errors; `None` if these are too many.
pub(crate) struct Root(DMatrix<f64>);

impl Root {
    pub(crate) fn new(machine: &CalibratedMachine) -> Option<Self> {
        let count = machine.values().len();
        if count > MOST_RESULTS {
            return None;
        }
        let dense = machine.factors.dense();
        // µm and ″ are of one size, mm and rad are not.
        let u: Vec<f64> = (0..count).map(|i| dense[(i, i)].max(0.0).sqrt()).collect();
        let correlation = Mat::from_fn(count, count, |i, j| {
            let scale = u[i] * u[j];
            if scale > 0.0 {
                dense[(i, j)] / scale
            } else {
                0.0
            }
        });
        let SymmetricEigen { values, vectors } = symmetric_eigen(correlation.as_ref()).ok()?;
        let root = |i: usize, j: usize| {
            // Negative ones are rounding.
            u[i] * vectors[(i, j)] * values[j].max(0.0).sqrt()
        };
        Some(Self(DMatrix::from_fn(count, count, root)))
    }

    /// Draw `number`: errors of all results, mm and rad; the same for the same seed.
    pub(crate) fn draw(&self, seed: u64, number: u64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(number);
        let deviates =
            nalgebra::DVector::from_fn(self.0.ncols(), |_, _| rng.sample(StandardNormal));
        (&self.0 * deviates).as_slice().to_vec()
    }
}
