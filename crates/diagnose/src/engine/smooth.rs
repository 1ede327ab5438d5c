//! How much of what a model leaves a smooth process of unknown form explains.
//!
//! Its standard deviation maximises the restricted likelihood; its 2 ln B is flat over the correlation lengths. Its p-value is that of
//! the restricted likelihood ratio at the border `w = 0`, `½ P(χ²₁ > LR)`, which is conservative (Crainiceanu and Ruppert 2004).

use trueaxis_leastsquares::{chi_squared_upper_tail, dot};
use trueaxis_selection::{Projection, gram_matrix, mean_two_ln_b, restricted_likelihood};

/// Family-wise level of all disturbances of a set of data.
pub(crate) const SMOOTH_LEVEL: f64 = 0.002;

/// Correlation lengths that are tried, as parts of the range.
const LENGTHS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Least number of stops in a correlation length; faster changes are repeatability.
const LEAST_STOPS: f64 = 3.0;

/// Correlation lengths that courses with this number of stops can show.
pub(crate) fn correlation_lengths(stops: usize) -> Vec<f64> {
    let is_seen = |length: &f64| length * stops as f64 >= LEAST_STOPS;
    LENGTHS.into_iter().filter(is_seen).collect()
}

/// The most likely process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Smooth {
    /// Index of the spectrum.
    pub(crate) spectrum: usize,
    /// w, in standard deviations of the noise times the unit of the columns.
    pub(crate) width: f64,
    /// Twice the logarithm of its marginal likelihood ratio.
    pub(crate) two_ln_b: f64,
    /// P-value as if it were the only process tested.
    pub(crate) p_value: f64,
}

impl Smooth {
    /// The most likely process with whitened columns, whose coefficients have the prior standard deviations of one of
    /// the spectra, equally likely; `None` if the data do not show it.
    pub(crate) fn new(
        projection: &Projection,
        columns: &[Vec<f64>],
        spectra: &[Vec<f64>],
    ) -> Option<Self> {
        let n = columns.len();
        let matrix = gram_matrix(projection, columns);
        let dof = projection.degrees_of_freedom;
        // In standard deviations of the noise that is left.
        let scale = (dof / projection.squares()).sqrt();
        let along = projection.along(columns).into_iter();
        let along: Vec<f64> = along.map(|s| scale * s).collect();
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let fits = spectra.iter().enumerate().map(|(spectrum, roots)| {
            // What has no width would only take time.
            let kept: Vec<usize> = (0..n).filter(|&k| roots[k] > 0.0).collect();
            let pairs = kept.iter().flat_map(|i| kept.iter().map(move |k| (*i, *k)));
            let scaled = pairs.map(|(i, k)| matrix[i * n + k] * roots[i] * roots[k]);
            let scaled: Vec<f64> = scaled.collect();
            let before = kept.iter().map(|&k| before[k] * roots[k] * roots[k]);
            let before: Vec<f64> = before.collect();
            let s: Vec<f64> = kept.iter().map(|&k| along[k] * roots[k]).collect();
            let (variance, ratio) = restricted_likelihood(&scaled, &before, &s, dof);
            (spectrum, variance, ratio)
        });
        let fits: Vec<(usize, f64, f64)> = fits.collect();
        let &(spectrum, variance, ratio) = fits.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
        if variance <= 0.0 {
            return None;
        }
        let all_two_ln_b: Vec<f64> = fits.iter().map(|fit| fit.2).collect();
        Some(Self {
            spectrum,
            width: variance.sqrt(),
            two_ln_b: mean_two_ln_b(&all_two_ln_b, fits.len()),
            p_value: 0.5 * chi_squared_upper_tail(ratio, 1.0).max(f64::MIN_POSITIVE),
        })
    }
}

/// Twice the logarithm of the marginal likelihood ratio of processes against a model without them, and the model with
/// them. Each has columns scaled to its prior, and is one of a number that are equally likely.
pub(crate) fn beside_all(
    model: &Projection,
    processes: impl Iterator<Item = (Vec<Vec<f64>>, usize)>,
) -> (f64, Projection) {
    let (mut sum, mut model) = (0.0, model.clone());
    for (columns, likely) in processes {
        let (with, ln_price) = model.beside(&columns);
        let ratio = (with.squares() / model.squares()).max(f64::MIN_POSITIVE);
        sum -= model.degrees_of_freedom * ratio.ln() + ln_price + 2.0 * (likely as f64).ln();
        model = with;
    }
    (sum, model)
}

/// Posterior of coefficients with the prior `N(0, I)`: mean and covariance, in variances of the noise.
pub(crate) struct Posterior {
    pub(crate) mean: Vec<f64>,
    covariance: Vec<f64>,
}

impl Posterior {
    /// The posterior for whitened columns that are in the covariance of a model.
    pub(crate) fn new(model: &Projection, columns: &[Vec<f64>]) -> Self {
        let mean = model.along(columns);
        let mut covariance = gram_matrix(model, columns);
        let n = columns.len();
        for (ik, value) in covariance.iter_mut().enumerate() {
            *value = f64::from(u8::from(ik / n == ik % n)) - *value;
        }
        Self { mean, covariance }
    }

    /// A linear function of the coefficients from `first` on, with its variance.
    pub(crate) fn of(&self, first: usize, row: &[f64]) -> (f64, f64) {
        let (width, n) = (row.len(), self.mean.len());
        let through = |i: usize| dot(row, &self.covariance[(first + i) * n + first..][..width]);
        let variance: f64 = (0..width).map(|i| row[i] * through(i)).sum();
        (
            dot(row, &self.mean[first..first + width]),
            variance.max(0.0),
        )
    }
}
