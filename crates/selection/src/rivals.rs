//! Whether another hypothesis explains the data nearly as well.

use std::ops::Range;

use trueaxis_leastsquares::dot;

use crate::gram_matrix::gram;
use crate::projection::combined;
use crate::{Projection, Score, ln_f_test};

/// A hypothesis fitted at one shape.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Its parameters.
    pub estimates: Vec<f64>,
    /// Their covariance for unit variance, rows one after the other.
    pub covariance: Vec<f64>,
    /// Whether the data see all of each parameter.
    pub seen: Vec<bool>,
    /// `X θ`.
    pub effect: Vec<f64>,
    /// `M X θ`: what it explains of the residuals.
    pub explained: Vec<f64>,
}

impl Fit {
    /// Fits whitened columns to the residuals of a projection.
    pub fn new(projection: &Projection, columns: &[Vec<f64>]) -> Self {
        let gram = gram(projection, columns);
        let s = projection.along(columns);
        let estimates = gram.estimates(&s);
        let effect = combined(projection.rows(), columns, &estimates);
        Self {
            covariance: gram.covariance(),
            seen: gram.seen(),
            estimates,
            explained: projection.left_of(&effect),
            effect,
        }
    }

    /// The drop of the sum of squares.
    pub fn gained(&self) -> f64 {
        dot(&self.effect, &self.explained)
    }

    /// Logarithm of the p-value of as large a drop by noise alone, of columns of this rank.
    pub fn ln_p(&self, projection: &Projection, rank: usize) -> f64 {
        let (squares, freedom) = (projection.squares(), projection.degrees_of_freedom);
        ln_f_test(self.gained(), squares, rank, freedom)
    }

    /// The fit of some of its parameters.
    pub fn part(&self, own: Range<usize>) -> Self {
        let width = self.estimates.len();
        let pairs = own.clone().flat_map(|i| own.clone().map(move |k| (i, k)));
        Self {
            estimates: self.estimates[own.clone()].to_vec(),
            covariance: pairs.map(|(i, k)| self.covariance[i * width + k]).collect(),
            seen: self.seen[own].to_vec(),
            effect: Vec::new(),
            explained: Vec::new(),
        }
    }

    /// Whether the data allow values in their plausible ranges, within three standard uncertainties. For a value of
    /// more than two uncertainties the allowance is at most half the range, or a poorly known value far outside would
    /// represent its effect. `variance` is that of the observations.
    pub fn is_possible(&self, plausible: &[Option<[f64; 2]>], variance: f64) -> bool {
        let count = plausible.len();
        plausible.iter().enumerate().all(|(k, range)| {
            let (value, u) = (
                self.estimates[k],
                (self.covariance[k * count + k].max(0.0) * variance).sqrt(),
            );
            range.is_none_or(|[low, high]| {
                let beyond = match value.abs() > 2.0 * u {
                    true => (3.0 * u).min(0.5 * (high - low)),
                    false => 3.0 * u,
                };
                value - beyond <= high && value + beyond >= low
            })
        })
    }
}

/// Cosine between what two hypotheses explain.
pub fn cosine(a: &Fit, b: &Fit) -> f64 {
    let lengths = a.gained() * b.gained();
    if lengths > 0.0 {
        dot(&a.effect, &b.explained) / lengths.sqrt()
    } else {
        0.0
    }
}

/// `2 ln` of the odds, 20 to 1, below which two hypotheses are rivals.
pub const DECISIVE: f64 = 6.0;

/// Explanations with a larger cosine than this are one explanation under two names.
pub const ALIKE: f64 = 0.95;

/// Whether `rival` is indistinguishable from the leader: by 2 ln B or BIC within 6, or because both explain the same.
/// With more free parameters an explanation is always at least as alike; then only 2 ln B decides, which counts
/// the coincidence.
pub fn is_rival(leader: &Score, rival: &Score, cosine: f64) -> bool {
    leader.two_ln_b - rival.two_ln_b < DECISIVE
        || rival.bic - leader.bic < DECISIVE
        || (cosine > ALIKE && rival.rank <= leader.rank)
}
