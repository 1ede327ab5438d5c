//! `G = Xᵀ M X` of a hypothesis in its eigenvectors.

use nalgebra::DMatrix;
use trueaxis_leastsquares::dense::{eigenvalues_along, symmetric_eigen};
use trueaxis_leastsquares::lane_products::LaneMatrix;
use trueaxis_leastsquares::{Lanes, in_widest_registers, lanes_only};

/// The combinations of the parameters that the data see.
#[derive(Debug, Clone)]
pub struct Gram {
    /// Eigenvalues of what is seen: squared strength of a unit of each combination.
    values: Vec<f64>,
    /// Their eigenvectors, one after the other.
    vectors: Vec<f64>,
    parameters: usize,
}

/// Least share of a column's squares that must be left after the projection. Below it the base model absorbs the
/// effect to one part in ten thousand: no data of this kind show it.
pub(crate) const VISIBLE: f64 = 1e-8;

/// Share of the squares of the largest column to which eigenvalues are exact.
const ROUNDING: f64 = 1e-13;

/// Share of a parameter in unseen combinations that is more than rounding.
const UNSEEN: f64 = 1e-6;

impl Gram {
    /// From `G` (square, rows one after the other) and the squares `|X_k|²` before the projection.
    pub fn new(gram: &[f64], before: &[f64]) -> Self {
        let n = before.len();
        let largest = largest(before);
        let mut new = Self {
            values: Vec::new(),
            vectors: Vec::new(),
            parameters: n,
        };
        if !gram.iter().all(|x| x.is_finite()) || largest <= 0.0 {
            return new;
        }
        // Of a combination of columns, as if these were orthogonal: what is seen depends little on their units.
        let limit = |vector: &[f64]| {
            let squares = vector.iter().zip(before);
            let own: f64 = squares.map(|(v, before)| v * v * before).sum();
            (VISIBLE * own).max(ROUNDING * largest)
        };
        if let Ok(eigen) = symmetric_eigen(DMatrix::from_fn(n, n, symmetric(gram, n))) {
            let vectors = eigen.eigenvectors.as_slice().chunks_exact(n);
            let all = eigen.eigenvalues.iter().zip(vectors);
            for (&value, vector) in all.filter(|(value, vector)| **value > limit(vector)) {
                new.values.push(value);
                new.vectors.extend(vector);
            }
        }
        new
    }

    /// Number of combinations that the data see.
    pub fn rank(&self) -> usize {
        self.values.len()
    }

    /// The coordinates of `s` in standard deviations; their squares add to `T`.
    pub fn standardised<'a>(&'a self, s: &'a [f64]) -> impl Iterator<Item = (f64, f64)> + 'a {
        let vectors = self.vectors.chunks_exact(self.parameters.max(1));
        self.values
            .iter()
            .zip(vectors)
            .map(move |(&value, vector)| {
                let along: f64 = vector.iter().zip(s).map(|(v, s)| v * s).sum();
                (value, along / value.sqrt())
            })
    }

    /// Eigenvalues, the coordinates of `s` in standard deviations, and eigenvectors.
    pub fn combinations<'a>(&'a self, s: &'a [f64]) -> impl Iterator<Item = (f64, f64, &'a [f64])> {
        let vectors = self.vectors.chunks_exact(self.parameters.max(1));
        let seen = self.standardised(s).zip(vectors);
        seen.map(|((value, z), vector)| (value, z, vector))
    }

    /// The statistic `T = sᵀ G⁺ s`.
    pub fn statistic(&self, s: &[f64]) -> f64 {
        self.standardised(s).map(|(_, z)| z * z).sum()
    }

    /// The statistics of several `s` at once: those in a column of `s`, which has a row for each parameter.
    pub fn statistics(&self, s: LaneMatrix<'_>, column: usize) -> Lanes {
        let mut statistics = Lanes::ZERO;
        let vectors = self.vectors.chunks_exact(self.parameters.max(1));
        in_widest_registers(
            #[inline(always)]
            || {
                for (&value, vector) in self.values.iter().zip(vectors) {
                    let mut along = Lanes::ZERO;
                    for (row, v) in vector.iter().enumerate() {
                        lanes_only();
                        along = Lanes::splat(*v).mul_add(s.at(row, column), along);
                    }
                    let z = along * Lanes::splat(value.sqrt().recip());
                    statistics += z * z;
                }
            },
        );
        statistics
    }

    /// The parameters `G⁺ s`; unseen combinations stay zero.
    pub fn estimates(&self, s: &[f64]) -> Vec<f64> {
        let mut estimates = vec![0.0; self.parameters];
        for (value, z, vector) in self.combinations(s) {
            for (estimate, v) in estimates.iter_mut().zip(vector) {
                *estimate += v * z / value.sqrt();
            }
        }
        estimates
    }

    /// Whether the data see all of each parameter. The estimate of any other contains only the part that they see.
    pub fn seen(&self) -> Vec<bool> {
        let n = self.parameters;
        let shares = (0..n).map(|k| {
            let vectors = self.vectors.chunks_exact(n.max(1));
            vectors.map(|vector| vector[k] * vector[k]).sum::<f64>()
        });
        shares.map(|share| share > 1.0 - UNSEEN).collect()
    }

    /// `G⁺`: covariance of the estimates, rows one after the other.
    pub fn covariance(&self) -> Vec<f64> {
        let n = self.parameters;
        let mut covariance = vec![0.0; n * n];
        for (value, vector) in self.values.iter().zip(self.vectors.chunks_exact(n.max(1))) {
            for i in 0..n {
                for j in 0..n {
                    covariance[i * n + j] += vector[i] * vector[j] / value;
                }
            }
        }
        covariance
    }

    /// 2 ln B, twice the logarithm of the Bayes factor, for a prior `N(0, w² I)` of the parameters, with the most
    /// likely width `w` (empirical Bayes): `max_w Σ z² w²g/(1 + w²g) - ln(1 + w²g)`, zero where no width gains.
    pub fn two_ln_b(&self, s: &[f64]) -> f64 {
        self.most_likely_variance(s).1
    }

    /// The 2 ln B from the coordinates ([`Self::standardised`]).
    pub fn two_ln_b_of(coordinates: &[(f64, f64)]) -> f64 {
        best_variance(coordinates, |gained, ln_price| gained - ln_price).1
    }

    /// The posterior mean of the parameters with the prior of [`Self::two_ln_b`]: combinations that the data hardly
    /// see stay near zero, so that the mean predicts other data well that do see them.
    pub fn shrunk(&self, s: &[f64]) -> Vec<f64> {
        let (variance, _) = self.most_likely_variance(s);
        let mut estimates = vec![0.0; self.parameters];
        for (value, z, vector) in self.combinations(s) {
            let x = variance * value;
            for (estimate, v) in estimates.iter_mut().zip(vector) {
                *estimate += v * z / value.sqrt() * x / (1.0 + x);
            }
        }
        estimates
    }

    /// The most likely `w²`, and `2 ln` of the marginal likelihood ratio for it.
    fn most_likely_variance(&self, s: &[f64]) -> (f64, f64) {
        let coordinates: Vec<(f64, f64)> = self.standardised(s).collect();
        best_variance(&coordinates, |gained, ln_price| gained - ln_price)
    }
}

/// Elements of a matrix made symmetric again after rounding.
fn symmetric(matrix: &[f64], n: usize) -> impl Fn(usize, usize) -> f64 {
    move |i, j| 0.5 * (matrix[i * n + j] + matrix[j * n + i])
}

fn largest(squares: &[f64]) -> f64 {
    squares.iter().fold(0.0_f64, |max, &own| max.max(own))
}

/// `w²` and `2 ln` of the likelihood ratio `max_w -ν ln(1 - Σ z² x/(1 + x)/ν) - Σ ln(1 + x)`, `x = w² g`, for a prior
/// `N(0, w² I)` of the parameters and the most likely variance of the noise (restricted maximum likelihood). The sum
/// of squares before is `ν`, its degrees of freedom. `G`, the squares of its columns before the projection, and `s`
/// are as in [`Gram`], which takes longer because it needs eigenvectors; here what is small against the largest column
/// counts as unseen.
pub fn restricted_likelihood(gram: &[f64], before: &[f64], s: &[f64], dof: f64) -> (f64, f64) {
    let (n, limit) = (before.len(), VISIBLE * largest(before));
    if limit <= 0.0 {
        return (0.0, 0.0);
    }
    let all = eigenvalues_along(s, symmetric(gram, n)).unwrap_or_default();
    let seen = all.into_iter().filter(|(value, _)| *value > limit);
    let seen: Vec<(f64, f64)> = seen.map(|(g, along)| (g, along / g.sqrt())).collect();
    best_variance(&seen, |gained, ln_price| {
        -dof * (1.0 - gained / dof).max(f64::MIN_POSITIVE).ln() - ln_price
    })
}

/// The variance of the prior with the largest likelihood, a function of its gain and ln price; and that likelihood.
fn best_variance(coordinates: &[(f64, f64)], likelihood: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let at = |variance: f64| -> f64 {
        let (mut gained, mut price, mut ln_price) = (0.0, 1.0, 0.0);
        for &(g, z) in coordinates {
            let x = variance * g;
            gained += z * z * x / (1.0 + x);
            price *= 1.0 + x;
            // The logarithm is expensive: one for the product of many.
            if price > LARGE {
                ln_price += price.ln();
                price = 1.0;
            }
        }
        likelihood(gained, ln_price + price.ln())
    };
    let Some(largest) = coordinates.iter().map(|(g, _)| *g).reduce(f64::max) else {
        return (0.0, 0.0);
    };
    // Their roots go from a tenth of the least uncertainty to twice the length of the estimates.
    let top: f64 = coordinates.iter().map(|&(g, z)| z * z / g).sum();
    let (low, high) = (0.01 / largest, (4.0 * top).max(0.02 / largest));
    let ratio = (high / low).powf(1.0 / VARIANCES as f64);
    let candidates = std::iter::successors(Some(low), |variance| Some(variance * ratio));
    let candidates = candidates.take(VARIANCES + 1);
    candidates
        .map(|variance| (variance, at(variance)))
        .fold(
            (0.0, 0.0),
            |best, next| if next.1 > best.1 { next } else { best },
        )
}

/// The product gets its logarithm before it can overflow.
const LARGE: f64 = 1e100;

/// Variances of the prior that are tried, in equal ratios; the maximum is flat.
const VARIANCES: usize = 40;
