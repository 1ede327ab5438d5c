//! The parameters of a cause with their uncertainties.
//!
//! Of an instant the data say that it lies between two visits, or in one of them: it is uniform over
//! that gap, whatever the likelihood says of its neighbours. A time constant joins the linear parameters
//! by its derivative, so that all of them carry its uncertainty.

use trueaxis_effects::{Scene, shape_parameter};

use crate::EstimatedParameter;
use crate::selection::{Fit, Hypothesis};

/// Parameters of a hypothesis with their values, the shape (value, standard uncertainty) last; `u` of the linear ones by
/// number.
pub(crate) fn with_uncertainties(
    scene: &Scene,
    hypothesis: &Hypothesis,
    values: &[f64],
    u: impl Fn(usize) -> f64,
    (shape, u_shape): (f64, f64),
) -> Vec<EstimatedParameter> {
    let Hypothesis {
        effect, subject, ..
    } = hypothesis;
    let linear = effect.parameters(scene, subject).into_iter().enumerate();
    let linear = linear.map(|(k, parameter)| (parameter, values[k], u(k)));
    let of_shape = shape_parameter(effect, scene, subject).map(|p| (p, shape, u_shape));
    let estimated =
        |(parameter, value, u): (trueaxis_effects::Parameter, f64, f64)| EstimatedParameter {
            name: parameter.name,
            value,
            u,
            unit: parameter.unit,
        };
    linear.chain(of_shape).map(estimated).collect()
}

/// Standard uncertainty of an instant within the gap between the starts of the visits before and after it, s.
pub(crate) fn u_in_gap_s(starts_s: impl Iterator<Item = f64> + Clone, instant_s: f64) -> f64 {
    let before = starts_s
        .clone()
        .filter(|&t| t <= instant_s)
        .fold(f64::NEG_INFINITY, f64::max);
    let after = starts_s
        .filter(|&t| t > instant_s)
        .fold(f64::INFINITY, f64::min);
    match before.is_finite() && after.is_finite() {
        true => (after - before) / 12_f64.sqrt(),
        false => 0.0,
    }
}

/// What the observations change by with a shape, from the columns at a shorter and a longer one.
pub(crate) fn by_shape(
    [shorter, longer]: [(f64, Vec<Vec<f64>>); 2],
    values: &[f64],
    rows: usize,
) -> Vec<f64> {
    let mut derivative = vec![0.0; rows];
    for ((a, b), value) in shorter.1.iter().zip(&longer.1).zip(values) {
        for ((d, a), b) in derivative.iter_mut().zip(a).zip(b) {
            *d += (b - a) * value / (longer.0 - shorter.0);
        }
    }
    derivative
}

/// Covariance of the first `n` parameters of a fit, and the standard uncertainty of the shape, which is the next one.
pub(crate) fn beside_shape(fit: &Fit, n: usize) -> (Vec<f64>, f64) {
    let width = fit.seen.len();
    let u = match fit.seen[n] {
        true => fit.covariance[n * width + n].sqrt(),
        false => f64::INFINITY,
    };
    let block = (0..n * n).map(|ik| fit.covariance[ik / n * width + ik % n]);
    (block.collect(), u)
}
