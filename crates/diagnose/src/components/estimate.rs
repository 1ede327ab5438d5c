//! The values of an effect with their uncertainties, averaged over the sizes of the rest of the curve.
//!
//! For each size (s, w) the parameters have an estimate and a covariance; over all sizes, with the weights of
//! [`crate::components::judgement`], these become
//!
//! ```text
//! θ = Σ π θ(s,w)        cov = Σ π [cov(s,w) + (θ(s,w) - θ)(θ(s,w) - θ)ᵀ]
//! ```
//!
//! A period is found by Gauss-Newton from the best one of the search: the derivative of the effect with respect to it
//! joins as a column, so that the covariance includes amplitude, phase and period. So are waves per turn where only a
//! small part of a turn was measured; they are rounded at the end. Meanwhile the phase of a wave is that in the middle
//! of the positions, where the period does not change it; at zero it may be off by any number of waves.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use trueaxis_selection::{combined, gram_of};

use crate::components::background::Background;
use crate::components::candidates::{
    Candidate, is_shortest, most_waves, shortest_distinguished, spacing, waves_apart,
};
use crate::components::curve_set::CurveSet;
use crate::components::judgement::ln_sum;
use crate::engine::{ByShape, derivative};
use trueaxis_effects::Shape;

/// An effect with its values.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    /// Linear parameters.
    pub(crate) parameters: Vec<f64>,
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) shape: f64,
    /// Its standard uncertainty; zero if it is not estimated.
    pub(crate) u_shape: f64,
    /// The effect in the curves, µm or arcsec.
    pub(crate) curve: Vec<f64>,
    /// The columns that remove the effect from a model to first order, including that of the period.
    pub(crate) columns: Vec<Vec<f64>>,
}

/// Largest number of Gauss-Newton steps; three bring the period to its last digits.
const MAX_STEPS: usize = 8;

/// Last step of the period in the iteration, in standard uncertainties.
const STEP_TOL: f64 = 1e-3;

/// Estimates a candidate from a shape near the right one.
pub(crate) fn estimate(
    set: &CurveSet,
    backgrounds: &[Background],
    candidate: &Candidate,
    shape: f64,
) -> Estimate {
    let kind = candidate.hypothesis.effect.shape;
    let middle = match kind {
        Shape::Period => set.middle(),
        _ => 0.0,
    };
    let columns_at = |shape| {
        let columns = set.columns(candidate, shape);
        match kind {
            Shape::Period => about(&columns, TAU * middle / shape),
            _ => columns,
        }
    };
    let linear = candidate.parameters;
    let mut columns = columns_at(shape);
    let (mut mean, mut covariance) = mixture(backgrounds, &columns);
    let (mut free, mut u_shape, mut unit) = (shape, 0.0, 0.0);
    if let Some([low, high]) = range_of_shape(set, kind, shape) {
        for _ in 0..MAX_STEPS {
            let derivative = derivative(columns_at, mean.rows(0, linear).as_slice(), free);
            columns = columns_at(free);
            let Some(by_shape) = ByShape::new(derivative, &columns) else {
                break;
            };
            columns.push(by_shape.column);
            (mean, covariance) = mixture(backgrounds, &columns);
            unit = by_shape.unit;
            u_shape = covariance[(linear, linear)].max(0.0).sqrt() * unit;
            let limit = match kind {
                Shape::Waves(_) => waves_apart(set).unwrap_or_default(),
                _ => spacing(set, free),
            };
            let step = (mean[linear] * unit).clamp(-limit, limit);
            free = (free + step).clamp(low.min(free), high);
            if step.abs() <= STEP_TOL * u_shape {
                break;
            }
        }
    }
    let shape = match kind {
        Shape::Waves(_) => free.round(),
        _ => free,
    };
    let parameters: Vec<f64> = mean.rows(0, linear).iter().copied().collect();
    let curve = combined(set.values.len(), &columns_at(shape), &parameters);
    let (parameters, covariance) = match kind {
        Shape::Period => at_zero(&parameters, &covariance, (TAU * middle, shape, unit)),
        _ => {
            let own = covariance.view((0, 0), (linear, linear));
            (parameters, own.into_owned())
        }
    };
    Estimate {
        curve,
        parameters,
        covariance,
        shape,
        u_shape,
        columns,
    }
}

/// Columns of sine and cosine about a position from those about zero: `ωx₀` is the angle.
fn about(columns: &[Vec<f64>], angle: f64) -> Vec<Vec<f64>> {
    let (sin, cos) = angle.sin_cos();
    let rows = columns[0].len();
    [[cos, -sin], [sin, cos]]
        .map(|factors| combined(rows, columns, &factors))
        .into()
}

/// Sine and cosine about zero with their covariance, from those about a position and, where it is estimated, the
/// period; with `2πx₀`, the period and its unit in the covariance.
fn at_zero(
    about: &[f64],
    covariance: &DMatrix<f64>,
    (turned, period, unit): (f64, f64, f64),
) -> (Vec<f64>, DMatrix<f64>) {
    let angle = turned / period;
    let (sin, cos) = angle.sin_cos();
    let [s, c] = [
        about[0] * cos + about[1] * sin,
        about[1] * cos - about[0] * sin,
    ];
    let by_period = -angle / period * unit;
    let jacobian = [cos, sin, by_period * c, -sin, cos, -by_period * s];
    let jacobian = DMatrix::from_row_slice(2, 3, &jacobian);
    let jacobian = jacobian.columns(0, covariance.ncols());
    let at_zero = jacobian * covariance * jacobian.transpose();
    (vec![s, c], at_zero)
}

/// Limits within which a shape is estimated: a period up to the travel and down to where the steps show one phase
/// only; `None` if the search has determined the shape.
fn range_of_shape(set: &CurveSet, kind: Shape, shape: f64) -> Option<[f64; 2]> {
    match kind {
        Shape::Period if !is_shortest(set, shape) => {
            Some([shortest_distinguished(set), set.travel()])
        }
        Shape::Waves(_) => waves_apart(set).map(|_| [1.0, most_waves(set).max(shape)]),
        _ => None,
    }
}

/// Mean and covariance of the coefficients of columns over all sizes of the rest.
fn mixture(backgrounds: &[Background], columns: &[Vec<f64>]) -> (DVector<f64>, DMatrix<f64>) {
    let n = columns.len();
    let mut of_sizes: Vec<(f64, DVector<f64>, DMatrix<f64>)> = Vec::new();
    for alike in backgrounds.chunk_by(Background::is_turned_as) {
        let turned = columns.iter().map(|c| alike[0].whitening.turned(c));
        let turned: Vec<Vec<f64>> = turned.collect();
        for background in alike {
            let projection = &background.projection;
            let whitened = turned.iter().map(|c| background.whitening.scaled(c));
            let whitened: Vec<Vec<f64>> = whitened.collect();
            let gram = gram_of(projection, &whitened);
            if gram.rank() == 0 {
                continue;
            }
            let s = projection.along(&whitened);
            let terms = gram.standardised(&s);
            let ln_likelihood: f64 = terms.map(|(value, z)| 0.5 * (z * z - value.ln())).sum();
            let values = DVector::from_vec(gram.estimates(&s));
            let covariance = DMatrix::from_row_slice(n, n, &gram.covariance());
            of_sizes.push((background.ln_weight + ln_likelihood, values, covariance));
        }
    }
    let total = ln_sum(of_sizes.iter().map(|size| size.0));
    let weight = |ln_weight: f64| (ln_weight - total).exp();
    let mut mean = DVector::zeros(n);
    for (ln_weight, values, _) in &of_sizes {
        mean += values * weight(*ln_weight);
    }
    let mut covariance = DMatrix::zeros(n, n);
    for (ln_weight, values, own) in &of_sizes {
        let apart = values - &mean;
        covariance += (own + &apart * apart.transpose()) * weight(*ln_weight);
    }
    (mean, covariance)
}
