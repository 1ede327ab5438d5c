//! A comparison as whitened observations, its base model and all hypotheses.
//!
//! Arrivals have one standard deviation σ, and are independent or autoregressive ([`Whitening`]). The errors of the
//! prediction join as unknowns with a pseudo-observation each, below the readings; here without correlation:
//!
//! ```text
//! [ (measured - predicted)/σ ]   [ B/σ  P/σ ] [ b ]
//! [            0             ] = [  0    I  ] [ x ] + noise of variance one
//! ```

use std::sync::Arc;

use trueaxis_effects::Scene;
use trueaxis_predict::CalibratedMachine;
use trueaxis_selection::Projection;

use crate::engine::linear::{Chosen, Listed};
use crate::engine::{Family, JudgedDisturbance, rms};
use crate::numbers::squares;
use crate::verification::autocorrelation::Noise;
use crate::verification::base::base_columns;
use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::candidates;
use crate::verification::omnibus::families;
use crate::verification::prediction_error::prediction_directions;
use crate::verification::wanderer::Course;
use crate::verification::whitening::Whitening;

/// What is to be explained, and what may explain it.
pub(crate) struct Problem<'a> {
    pub(crate) comparison: &'a Comparison<'a>,
    pub(crate) scene: &'a Scene,
    /// Whether the prediction is that of a calibration.
    pub(crate) calibrated: bool,
    /// Whether disturbances are in the covariance.
    pub(crate) wanders: bool,
    /// How the rows are whitened.
    pub(crate) whitening: Whitening<'a>,
    /// Share of the last digit of the readings in its variance.
    pub(crate) least_variance: f64,
    /// Share of the variance of a row that the last digit hides from the residuals.
    pub(crate) hidden: f64,
    /// The base model and the hypotheses.
    pub(crate) listed: Listed<'a>,
    /// The projection of the base model with the prediction taken as it is, for readings that are held out: a
    /// prediction that learns from the other readings is no longer that of the calibration.
    pub(crate) as_predicted: Projection,
    /// Standard uncertainty of the prediction, rms over the readings, µm.
    pub(crate) prediction_u_um: Option<f64>,
    /// Families of columns with which what is left may vary.
    pub(crate) families: Arc<[Family]>,
    /// Level of false alarms.
    pub(crate) level: f64,
}

impl<'a> Problem<'a> {
    /// With the standard uncertainty from the last digit and the noise it hides; `level` is that of false alarms.
    pub(crate) fn new(
        comparison: &'a Comparison<'a>,
        scene: &'a Scene,
        calibration: Option<&CalibratedMachine>,
        level: f64,
        Noise {
            sigma_um,
            correlation,
        }: Noise,
        (resolution_um, hidden_um): (f64, f64),
    ) -> Self {
        let prediction = calibration.map(|c| prediction_directions(&[comparison], c, sigma_um));
        let prediction = prediction.unwrap_or_default();
        let whitening = Whitening {
            lags: &comparison.lags,
            sigma_um,
            correlation,
            pseudo: prediction.len(),
        };
        let whiten = |column: &Vec<f64>| whitening.whiten(column);
        let base = base_columns(comparison, calibration.is_some());
        let mut columns: Vec<Vec<f64>> = base.iter().map(whiten).collect();
        let observations = whiten(&comparison.difference_um);
        let as_predicted = Projection::dense(observations.clone(), &columns);
        let mut variance = 0.0;
        for direction in &prediction {
            let own = as_predicted.left_of(&whiten(direction));
            variance += squares(&whitening.um(&own)) / direction.len() as f64;
        }
        for (k, direction) in prediction.iter().enumerate() {
            let mut column = whiten(direction);
            column[direction.len() + k] = 1.0;
            columns.push(column);
        }
        let hidden = (hidden_um / sigma_um).powi(2);
        let base = match prediction.is_empty() {
            true => as_predicted.clone(),
            false => Projection::dense(observations, &columns),
        };
        let base = base.with_hidden(hidden);
        let candidates = candidates(comparison, scene, whitening);
        Self {
            as_predicted,
            prediction_u_um: (!prediction.is_empty()).then(|| variance.sqrt()),
            comparison,
            scene,
            calibrated: calibration.is_some(),
            wanders: false,
            families: families(comparison, whitening).into(),
            level,
            whitening,
            hidden,
            least_variance: (resolution_um / sigma_um).powi(2) + hidden,
            listed: Listed::new(base, candidates.into()),
        }
    }

    /// The same with disturbances in the covariance.
    pub(crate) fn beside(&self, wandering: &[JudgedDisturbance]) -> Self {
        let columns: Vec<Vec<f64>> = wandering.iter().flat_map(|w| w.columns(self)).collect();
        let wanders = !columns.is_empty();
        let beside = |projection: &Projection| projection.beside(&columns).0;
        let (as_predicted, listed) = match wanders {
            // With the comparisons that were made.
            false => (self.as_predicted.clone(), self.listed.clone()),
            true => (
                beside(&self.as_predicted),
                self.listed.on(beside(&self.listed.base)),
            ),
        };
        Self {
            as_predicted,
            wanders,
            listed,
            families: self.families.clone(),
            ..*self
        }
    }

    /// The course of a disturbance of the readings.
    pub(crate) fn course(&self, own: &JudgedDisturbance) -> Course<'_, 'a> {
        Course {
            comparison: self.comparison,
            wanderer: own.wanderer(),
        }
    }

    /// Number of readings, without the pseudo-observations.
    pub(crate) fn readings(&self) -> usize {
        self.listed.base.rows() - self.whitening.pseudo
    }

    /// The prediction taken as it is with causes in the model, for readings beside those of others: with what the
    /// last digit hides of their noise, which pseudo-observations do not have.
    pub(crate) fn part(&self, causes: &[Chosen]) -> Projection {
        let part = self.as_predicted.extended(&self.listed.columns(causes));
        let of_readings = 1.0 - self.whitening.pseudo as f64 / part.degrees_of_freedom;
        part.with_hidden(self.hidden * of_readings.max(0.0))
    }

    /// Standard deviation of a single reading, µm.
    pub(crate) fn reading_um(&self) -> f64 {
        self.whitening.sigma_um * (1.0 - self.hidden).max(0.0).sqrt()
    }

    /// A column over the readings as one of the model.
    pub(crate) fn whiten(&self, column: &[f64]) -> Vec<f64> {
        self.whitening.whiten(column)
    }

    /// The readings of a column of the model, µm.
    pub(crate) fn um(&self, whitened: &[f64]) -> Vec<f64> {
        self.whitening.um(whitened)
    }

    /// Rms of something slow against the correlation of the noise, from these whitened squares, µm.
    pub(crate) fn slow_rms_um(&self, squares: f64) -> f64 {
        let rho = self.whitening.correlation;
        let variance = squares.max(0.0) / self.readings() as f64 * (1.0 + rho) / (1.0 - rho);
        self.whitening.sigma_um * variance.sqrt()
    }

    /// Rms per degree of freedom of what a model leaves and the last digit hides, µm.
    pub(crate) fn rms_um(&self, model: &Projection) -> f64 {
        self.whitening.sigma_um * rms(model)
    }

    /// Standard deviation of a reading that a model leaves, µm: at least that of the last digit.
    pub(crate) fn noise_um(&self, model: &Projection) -> f64 {
        let least_um = self.whitening.sigma_um * self.least_variance.sqrt();
        self.rms_um(model).max(least_um)
    }

    /// Rms per degree of freedom of the visible part of the readings less the prediction as it is and causes, µm.
    pub(crate) fn seen_rms_um(&self, causes: &[Chosen]) -> f64 {
        let left = self.part(causes);
        let degrees_of_freedom = left.degrees_of_freedom - self.whitening.pseudo as f64;
        let seen = (left.squares() - self.hidden * degrees_of_freedom).max(0.0);
        self.whitening.sigma_um * (seen / degrees_of_freedom.max(1.0)).sqrt()
    }
}
