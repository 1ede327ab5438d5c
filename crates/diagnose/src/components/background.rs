//! The rest of a curve that no effect explains, for all its possible sizes.
//!
//! Its covariance is `s² K + w² I`. K is that of a Gauss-Markov process of second or of first order (Matérn 3/2, 1/2),
//!
//! ```text
//! K(d) = (1 + √3 d/ℓ) exp(-√3 d/ℓ)     or     exp(-d/ℓ)
//! ```
//!
//! The power of the first falls with the fourth power of the frequency: such a curve is continuous, with a continuous
//! slope, as guideways and bearings are. That of the second falls with the second power, as where pitch errors of a screw
//! or a scale, independent of each other, add up: with Matérn 3/2 alone such a curve has waves. Both are equally likely.
//! d is the distance of two positions and ℓ twice the travel of a linear axis; for a rotary one d is the chord `2 sin(Δ/2)`, so that 0° and 360° are the same position, and ℓ = 2. This is an
//! assumption about machines, and (Matérn 3/2) it decides how large a slope or a single wave must be to stand out: the straight
//! part of a curve is expected to have, at the ends of the travel, about five times the rms of the bent part, and one
//! wave per turn 2.4 times the amplitude of two. A shorter ℓ expects less (three times with ℓ the travel) and names
//! more curves. s and w are not known: they run
//! over a grid in equal ratios, w with a flat prior, s with one from the other curves
//! ([`crate::components::smooth_prior`]).
//!
//! For each s one eigenvalue decomposition `C + s² K = Q Λ Qᵀ` whitens for all w: `(Λ + w²)^{-1/2} Qᵀ`. If all values
//! are independent with the same variance, as in a line, one decomposition of K serves for all s.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use rayon::prelude::*;
use trueaxis_kinematics::AxisKind;
use trueaxis_leastsquares::median;
use trueaxis_selection::{Projection, lengths_beside_earlier};

use crate::components::curve_set::CurveSet;
use crate::components::smooth_prior::SmoothPrior;
use crate::numbers::extremes;

/// One size of the rest, and the curves whitened with it.
#[derive(Debug, Clone)]
pub(crate) struct Background {
    /// Logarithm of the prior times the restricted likelihood of the curves without any effect.
    pub(crate) ln_weight: f64,
    /// The same without the prior of s.
    pub(crate) ln_likelihood: f64,
    /// Index of s in the grid.
    pub(crate) smooth: i32,
    /// Whitened curves with the base projected out.
    pub(crate) projection: Projection,
    pub(crate) whitening: Whitening,
}

/// `(Λ + w²)^{-1/2} Qᵀ`.
#[derive(Debug, Clone)]
pub(crate) struct Whitening {
    /// `Qᵀ`, the same for all w of an s.
    turn: Arc<DMatrix<f64>>,
    /// `(Λ + w²)^{-1/2}`.
    pub(crate) scales: Vec<f64>,
}

/// Ratio of neighbouring sizes: the likelihood of a standard deviation that 20 steps show has a width of 1/√40 in its
/// logarithm, and half of that on either side of a grid point.
const RATIO: f64 = std::f64::consts::SQRT_2;

/// Smallest smooth and rough rest, in standard uncertainties of the curve: they change no result.
const LEAST_SMOOTH: f64 = 0.1;
const LEAST_ROUGH: f64 = 0.1;

/// Largest smooth rest in units of the curve's range.
const MOST_SMOOTH: f64 = 3.0;

/// ℓ of a linear axis in travels.
const TRAVELS: f64 = 2.0;

/// Largest index of the grid: from 10⁻⁹ to 10⁹ µm.
const LARGEST_NUMBER: i32 = 60;

/// Range of a curve that is zero throughout, µm or arcsec.
const LEAST_RANGE: f64 = 1e-6;

/// Uncertainty assumed for exact curves, relative to their range.
const EXACT: f64 = 1e-3;

/// `C + s² K = Q Λ Qᵀ` of a smooth rest, whatever else is in the model.
pub(crate) struct Smooth {
    /// Index of s in the grid.
    number: i32,
    /// `Λ`.
    values: DVector<f64>,
    /// `Qᵀ`.
    turn: Arc<DMatrix<f64>>,
}

/// All sizes of the smooth rest of curves.
pub(crate) fn smooth_rests(set: &CurveSet) -> Vec<Smooth> {
    let kernels = [bent_alike, adding_up].map(|of_distance| kernel(set, of_distance));
    let rests = kernels.into_iter().map(|kernel| rests_with(set, kernel));
    rests.flatten().collect()
}

/// The same with one K.
fn rests_with(set: &CurveSet, kernel: DMatrix<f64>) -> Vec<Smooth> {
    let (u, range) = scales(set);
    let numbers = numbers(LEAST_SMOOTH * u, MOST_SMOOTH * range);
    let numbers = numbers.into_par_iter();
    if let Some(variance) = common_variance(&set.covariance) {
        let eigen = SymmetricEigen::new(kernel);
        let turn = Arc::new(eigen.eigenvectors.transpose());
        let of_number = |number: i32| Smooth {
            number,
            values: eigen
                .eigenvalues
                .map(|value| variance + size(number).powi(2) * value),
            turn: Arc::clone(&turn),
        };
        return numbers.map(of_number).collect();
    }
    let of_number = |number: i32| {
        let s = size(number);
        let eigen = SymmetricEigen::new(&set.covariance + &kernel * (s * s));
        Smooth {
            number,
            values: eigen.eigenvalues,
            turn: Arc::new(eigen.eigenvectors.transpose()),
        }
    };
    numbers.map(of_number).collect()
}

/// The variance of all values, if they are independent with the same variance.
fn common_variance(covariance: &DMatrix<f64>) -> Option<f64> {
    let variance = *covariance.get(0)?;
    let is_common = *covariance
        == DMatrix::from_diagonal_element(covariance.nrows(), covariance.ncols(), variance);
    is_common.then_some(variance)
}

/// The curves for all sizes of the rest; `base` contains what the gauge takes out and the effects in the model.
pub(crate) fn backgrounds(
    set: &CurveSet,
    smooth: &[Smooth],
    base: &[Vec<f64>],
    prior: &SmoothPrior,
) -> Vec<Background> {
    let (u, range) = scales(set);
    let rough = numbers(LEAST_ROUGH * u, range.max(u));
    let rough: Vec<f64> = rough.into_iter().map(size).collect();
    let mut all = Vec::with_capacity(smooth.len() * rough.len());
    for Smooth {
        number,
        values,
        turn,
    } in smooth
    {
        let number = *number;
        let base = base.iter().map(|column| turned(turn, column));
        let base: Vec<Vec<f64>> = base.collect();
        let curves = turned(turn, &set.values);
        for &w in &rough {
            let variances = values.map(|value| value.max(0.0) + w * w);
            let whitening = Whitening {
                turn: Arc::clone(turn),
                scales: variances.iter().map(|v| 1.0 / v.sqrt()).collect(),
            };
            let whitened: Vec<Vec<f64>> = base.iter().map(|c| whitening.scaled(c)).collect();
            let projection = Projection::dense(whitening.scaled(&curves), &whitened);
            // Flat in w: in equal ratios each point represents an interval in proportion to w.
            let ln_likelihood = w.ln()
                - 0.5
                    * (variances.iter().map(|v| v.ln()).sum::<f64>()
                        + ln_determinant(&whitened)
                        + projection.squares());
            all.push(Background {
                ln_weight: ln_likelihood + prior.ln_mass(number),
                ln_likelihood,
                smooth: number,
                projection,
                whitening,
            });
        }
    }
    all
}

impl Background {
    /// Whether both have the same rotation, so that rotated columns serve both.
    pub(crate) fn is_turned_as(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.whitening.turn, &other.whitening.turn)
    }
}

impl Whitening {
    pub(crate) fn whiten(&self, column: &[f64]) -> Vec<f64> {
        self.scaled(&self.turned(column))
    }

    /// Rotates a column by `Qᵀ`, which is the same for all sizes with one s.
    pub(crate) fn turned(&self, column: &[f64]) -> Vec<f64> {
        turned(&self.turn, column)
    }

    /// Rotates all columns of a matrix at once.
    pub(crate) fn turned_all(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        &*self.turn * columns
    }

    /// Whitens a rotated column.
    pub(crate) fn scaled(&self, turned: &[f64]) -> Vec<f64> {
        let pairs = self.scales.iter().zip(turned);
        pairs.map(|(scale, x)| scale * x).collect()
    }
}

/// `Qᵀ x`.
fn turned(turn: &DMatrix<f64>, column: &[f64]) -> Vec<f64> {
    let mut turned = vec![0.0; column.len()];
    let values = column.iter().enumerate();
    for (j, &value) in values.filter(|(_, value)| **value != 0.0) {
        for (sum, element) in turned.iter_mut().zip(turn.column(j).iter()) {
            *sum += element * value;
        }
    }
    turned
}

/// Matérn 3/2 at a distance in ℓ.
fn bent_alike(distance: f64) -> f64 {
    let x = 3.0_f64.sqrt() * distance;
    (1.0 + x) * (-x).exp()
}

/// Matérn 1/2 at a distance in ℓ.
fn adding_up(distance: f64) -> f64 {
    (-distance).exp()
}

/// K of all curves of a set; it is zero between different curves.
fn kernel(set: &CurveSet, of_distance: fn(f64) -> f64) -> DMatrix<f64> {
    let steps = set.nodes.len();
    let travel = set.travel();
    DMatrix::from_fn(set.values.len(), set.values.len(), |i, j| {
        if i / steps != j / steps {
            return 0.0;
        }
        let apart = set.nodes[i % steps].0 - set.nodes[j % steps].0;
        let distance_in_l = match set.content.kind() {
            AxisKind::Linear => apart / (TRAVELS * travel),
            AxisKind::Rotary => (0.5 * apart).sin(),
        };
        of_distance(distance_in_l.abs())
    })
}

/// Median standard uncertainty and largest range of the curves.
fn scales(set: &CurveSet) -> (f64, f64) {
    let ranges = set.values.chunks_exact(set.nodes.len()).map(|curve| {
        let [low, high] = extremes(curve.iter().copied());
        high - low
    });
    let range = ranges.fold(LEAST_RANGE, f64::max);
    let variances = set.covariance.diagonal();
    let mut u: Vec<f64> = variances.iter().map(|v| v.max(0.0).sqrt()).collect();
    let u = median(&mut u).unwrap_or(0.0);
    (u.max(EXACT * range), range)
}

/// Indices of the sizes from `low` to `high`.
fn numbers(low: f64, high: f64) -> Vec<i32> {
    let mut numbers: Vec<i32> = (-LARGEST_NUMBER..=LARGEST_NUMBER).collect();
    numbers.retain(|&k| (low..=high.max(RATIO * low)).contains(&size(k)));
    numbers
}

/// The size with this index, µm or arcsec; the same for all curves.
pub(crate) fn size(number: i32) -> f64 {
    RATIO.powi(number)
}

/// `ln det BᵀB`.
fn ln_determinant(columns: &[Vec<f64>]) -> f64 {
    let lengths = lengths_beside_earlier(columns).into_iter();
    2.0 * lengths.map(|x| x.max(f64::MIN_POSITIVE).ln()).sum::<f64>()
}
