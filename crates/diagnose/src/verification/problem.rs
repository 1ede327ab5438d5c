//! A comparison as whitened observations, its base model and all hypotheses.
//!
//! Arrivals are independent with one standard deviation σ. The prediction's own errors join as
//! unknowns with a pseudo-observation each, below the readings:
//!
//! ```text
//! [ (measured - predicted)/σ ]   [ B/σ  P/σ ] [ b ]
//! [            0             ] = [  0    I  ] [ x ] + noise of variance one
//! ```

use trueaxis_effects::Scene;

use crate::selection::{FixedScan, Projection, Scan};
use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::{Candidate, candidates};

/// What there is to explain, and what may explain it.
pub(crate) struct Problem<'a> {
    /// The data.
    pub(crate) comparison: &'a Comparison<'a>,
    /// Standard deviation of an arrival that the rows are divided by, µm.
    pub(crate) sigma_um: f64,
    /// The part of its variance that the last digit of the readings has.
    pub(crate) least_variance: f64,
    /// The base model's projection.
    pub(crate) base: Projection,
    /// That of the base model with the prediction taken as it is, for readings that are held out: a
    /// prediction that learns from the other readings is no longer that of the calibration.
    pub(crate) as_predicted: Projection,
    /// The hypotheses.
    pub(crate) candidates: Vec<Candidate>,
    pseudo: usize,
}

/// A hypothesis in the model, at one shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Chosen {
    /// Which.
    pub(crate) candidate: usize,
    /// Its shape.
    pub(crate) shape: f64,
    /// Standard deviation of the shape.
    pub(crate) u_shape: f64,
}

impl<'a> Problem<'a> {
    /// `base` and `prediction` are columns over the readings, µm per unit.
    pub(crate) fn new(
        comparison: &'a Comparison<'a>,
        scene: &Scene,
        (sigma_um, resolution_um): (f64, f64),
        base: &[Vec<f64>],
        prediction: &[Vec<f64>],
    ) -> Self {
        let pseudo = prediction.len();
        let whiten = |column: &[f64]| whitened(column, sigma_um, pseudo);
        let mut columns: Vec<Vec<f64>> = base.iter().map(|c| whiten(c)).collect();
        let observations = whiten(&comparison.difference_um);
        let as_predicted = Projection::dense(observations.clone(), &columns);
        for (k, direction) in prediction.iter().enumerate() {
            let mut column = whiten(direction);
            column[direction.len() + k] = 1.0;
            columns.push(column);
        }
        let base = Projection::dense(observations, &columns);
        Self {
            as_predicted,
            comparison,
            sigma_um,
            least_variance: (resolution_um / sigma_um).powi(2),
            base,
            candidates: candidates(comparison, scene, |column| whiten(&column)),
            pseudo,
        }
    }

    /// Readings, without the pseudo-observations.
    pub(crate) fn readings(&self) -> usize {
        self.base.rows() - self.pseudo
    }

    /// A column over the readings as one of the model.
    pub(crate) fn whiten(&self, column: &[f64]) -> Vec<f64> {
        whitened(column, self.sigma_um, self.pseudo)
    }

    /// The columns of causes, one cause after the other.
    pub(crate) fn columns(&self, causes: &[Chosen]) -> Vec<Vec<f64>> {
        let of_cause = |chosen: &Chosen| self.candidates[chosen.candidate].columns(chosen.shape);
        causes.iter().flat_map(of_cause).cloned().collect()
    }

    /// The projection with causes in the model.
    pub(crate) fn with(&self, causes: &[Chosen]) -> Projection {
        self.base.extended(&self.columns(causes))
    }

    /// The hypotheses that the data can see beside a model with causes, and which candidate each is.
    ///
    /// No effect happens twice to the same subject: a second time constant or period of the same name
    /// would fit anything.
    pub(crate) fn scans(
        &self,
        model: &Projection,
        causes: &[Chosen],
    ) -> (Vec<Box<dyn Scan>>, Vec<usize>) {
        let mut scans: Vec<Box<dyn Scan>> = Vec::new();
        let mut numbers = Vec::new();
        for (number, candidate) in self.candidates.iter().enumerate() {
            if causes.iter().any(|cause| cause.candidate == number) {
                continue;
            }
            let columns = |shape: f64| candidate.columns(shape).to_vec();
            if let Some(scan) =
                FixedScan::new(candidate.hypothesis, model, &candidate.shapes, columns)
            {
                scans.push(Box::new(scan));
                numbers.push(number);
            }
        }
        (scans, numbers)
    }

    /// Rms for one degree of freedom of what a model leaves, µm.
    pub(crate) fn rms_um(&self, model: &Projection) -> f64 {
        self.sigma_um * (model.squares() / model.degrees_of_freedom.max(1.0)).sqrt()
    }
}

fn whitened(column: &[f64], sigma_um: f64, pseudo: usize) -> Vec<f64> {
    let mut row: Vec<f64> = column.iter().map(|x| x / sigma_um).collect();
    row.resize(column.len() + pseudo, 0.0);
    row
}
