//! The lengths adjusted with causes.

use std::sync::Arc;

use trueaxis_leastsquares::dot;
use trueaxis_multilateration::{Network, Solution, Whitened};
use trueaxis_selection::{Fit, Projection};

use crate::engine::Suspect;

/// An adjusted model.
#[derive(Clone)]
pub(crate) struct Adjusted {
    /// The network with the noise used; its lengths are less the effects of the causes.
    pub(crate) network: Network,
    pub(crate) solution: Solution,
    /// Whitened rows of the rigid model.
    pub(crate) whitened: Arc<Whitened>,
    /// What neither the rigid model nor the causes absorb.
    pub(crate) projection: Projection,
    /// What the rigid model does not absorb, with disturbances in the covariance and without causes.
    pub(crate) before_causes: Arc<Projection>,
    /// The causes with their parameters.
    pub(crate) suspects: Vec<Suspect>,
}

/// Parameters of causes have converged when they move by less than this share of their uncertainty.
const RESTS: f64 = 1e-3;

/// Relative difference of residuals and their projection below which the residuals are already projected.
const PROJECTED: f64 = 1e-6;

/// Whether a rigid model absorbs nothing more of whitened residuals. It does where something is known beforehand, such as a dead path, or how
/// the constants of reflectors scatter.
pub(super) fn is_projected(whitened: &Whitened, residuals: &[f64]) -> bool {
    let mut again = residuals.to_vec();
    whitened.project(&mut again);
    let taken = again.iter().zip(residuals).map(|(a, b)| (a - b).powi(2));
    taken.sum::<f64>() <= PROJECTED.powi(2) * dot(residuals, residuals)
}

impl Adjusted {
    /// Whether the rigid model absorbs nothing more of its residuals.
    pub(super) fn is_projected(&self) -> bool {
        let mut residuals = self.solution.residuals_mm.clone();
        self.whitened.whiten(&mut residuals);
        is_projected(&self.whitened, &residuals)
    }

    /// Moves the parameters by a fit of what is left; returns whether they have converged.
    pub(super) fn update(&mut self, fit: &Fit) -> bool {
        let mut first = 0;
        let mut rests = true;
        for suspect in &mut self.suspects {
            let count = suspect.parameters.len();
            let own = fit.part(first..first + count);
            first += count;
            suspect.covariance = own.covariance;
            for (k, step) in own.estimates.iter().enumerate() {
                suspect.parameters[k] += step;
                let u = suspect.covariance[k * count + k].sqrt();
                rests &= step.abs() <= RESTS * u;
            }
        }
        rests
    }
}
