//! The lengths with what wanders in their covariance.

use trueaxis_multilateration::{Settings, Solution, Whitened, solve_from};

use crate::Error;
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::lengths::disturbance::Disturbance;
use crate::selection::{Projection, dot};

impl Base<'_> {
    /// The same lengths with what wanders in their covariance.
    pub(crate) fn beside(&self, disturbances: Vec<Disturbance>) -> Self {
        let mut beside = self.clone();
        beside.disturbances = disturbances;
        beside
    }

    /// The projection without causes, what wanders in the covariance.
    pub(crate) fn before_causes(&self, whitened: &Whitened, solution: &Solution) -> Projection {
        let bare = Projection::of_network(whitened);
        self.disturbances.iter().fold(bare, |projection, own| {
            let columns = self.whitened_columns(own, whitened, solution);
            projection.beside(&columns).0
        })
    }

    /// Columns of a disturbance with coefficients of unit variance.
    pub(crate) fn whitened_columns(
        &self,
        disturbance: &Disturbance,
        whitened: &Whitened,
        solution: &Solution,
    ) -> Vec<Vec<f64>> {
        let mut columns = disturbance.columns_mm(self, solution);
        columns
            .iter_mut()
            .for_each(|column| whitened.whiten(column));
        columns
    }

    /// What wanders does to each reading of `at`, as far as these lengths show it (posterior mean), mm.
    pub(crate) fn wandered_mm(&self, adjusted: &Adjusted, at: &Base<'_>) -> Vec<f64> {
        let mut sum_mm = vec![0.0; at.readings.len()];
        for disturbance in &self.disturbances {
            let Adjusted {
                whitened, solution, ..
            } = adjusted;
            let own = self.whitened_columns(disturbance, whitened, solution);
            for (own, there) in own.iter().zip(disturbance.columns_mm(at, solution)) {
                let coefficient = dot(own, &adjusted.projection.residuals);
                for (sum, x) in sum_mm.iter_mut().zip(&there) {
                    *sum += coefficient * x;
                }
            }
        }
        sum_mm
    }

    /// The model adjusted to what is left of its lengths without what wanders: its poses and stations are then
    /// those of generalised least squares.
    pub(crate) fn less(&self, adjusted: &Adjusted, wandered_mm: &[f64]) -> Result<Adjusted, Error> {
        let mut network = adjusted.network.clone();
        for (reading, wandered_mm) in network.readings.iter_mut().zip(wandered_mm) {
            reading.length_mm -= wandered_mm;
        }
        let solution = solve_from(&network, &adjusted.solution, &Settings::default())?;
        Ok(Adjusted {
            network,
            solution,
            suspects: adjusted.suspects.clone(),
            ..adjusted.with(adjusted.projection.clone())
        })
    }
}
