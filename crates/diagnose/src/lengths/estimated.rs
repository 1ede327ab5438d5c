//! The parameters of a cause with their uncertainties.
//!
//! Of an instant the data say that it lies between two visits, or in one of them: it is uniform over
//! that gap, whatever the likelihood says of its neighbours. A time constant joins the linear parameters
//! by its derivative, so that all of them carry its uncertainty.

use trueaxis_effects::{Shape, shape_parameter};

use crate::EstimatedParameter;
use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::hypotheses::{duration_s, visit_times};
use crate::selection::Fit;

/// Step of the logarithm of a time constant for its derivative.
const STEP: f64 = 0.01;

/// Values with standard uncertainties, the shape last, and the covariance of the linear ones (rows one
/// after the other). What the data do not see of a parameter makes its uncertainty infinite.
pub(crate) fn estimated(
    base: &Base<'_>,
    adjusted: &Adjusted,
    suspect: &Suspect,
) -> (Vec<EstimatedParameter>, Vec<f64>) {
    let hypothesis = suspect.hypothesis;
    let parameters = hypothesis
        .effect
        .parameters(&base.scene, &hypothesis.subject);
    let n = parameters.len();
    let mut covariance = suspect.covariance.clone();
    let mut u_shape = suspect.u_shape;
    match hypothesis.effect.shape {
        Shape::Instant => u_shape = u_shape.hypot(gap_s(base, suspect.shape) / 12_f64.sqrt()),
        Shape::TimeConstant | Shape::SettlingTime | Shape::Lag => {
            let (joint, u) = with_time_constant(base, adjusted, suspect);
            covariance = joint;
            u_shape = u;
        }
        Shape::Fixed | Shape::Period | Shape::Waves => {}
    }
    let u = |k: usize| match suspect.seen.get(k) {
        Some(false) => f64::INFINITY,
        _ => covariance[k * n + k].max(0.0).sqrt(),
    };
    let mut all: Vec<EstimatedParameter> = Vec::with_capacity(n + 1);
    for (k, parameter) in parameters.into_iter().enumerate() {
        all.push(EstimatedParameter {
            name: parameter.name,
            value: suspect.parameters[k],
            u: u(k),
            unit: parameter.unit,
        });
    }
    if let Some(shape) = shape_parameter(hypothesis.effect, &base.scene, &hypothesis.subject) {
        all.push(EstimatedParameter {
            name: shape.name,
            value: suspect.shape,
            u: u_shape,
            unit: shape.unit,
        });
    }
    (all, covariance)
}

/// From the start of the visit before an instant to the start of the one after it, s.
fn gap_s(base: &Base<'_>, instant_s: f64) -> f64 {
    let visits = visit_times(base);
    let starts = || visits.iter().map(|visit| visit.span_s[0]);
    let before = starts()
        .filter(|&t| t <= instant_s)
        .fold(f64::NEG_INFINITY, f64::max);
    let after = starts()
        .filter(|&t| t > instant_s)
        .fold(f64::INFINITY, f64::min);
    if before.is_finite() && after.is_finite() {
        after - before
    } else {
        0.0
    }
}

/// Covariance of the parameters and standard uncertainty of the time constant, all free together.
fn with_time_constant(base: &Base<'_>, adjusted: &Adjusted, suspect: &Suspect) -> (Vec<f64>, f64) {
    let at = |shape: f64| base.columns(adjusted, &suspect.hypothesis, shape);
    let mut columns = at(suspect.shape);
    let n = columns.len();
    // Of a lag that is almost none, a part of the campaign.
    let step = STEP * suspect.shape.max(STEP * duration_s(&visit_times(base)));
    let (shorter, longer) = ((suspect.shape - step).max(0.0), suspect.shape + step);
    let mut derivative = vec![0.0; base.readings.len()];
    for ((a, b), value) in at(shorter).iter().zip(&at(longer)).zip(&suspect.parameters) {
        for ((d, a), b) in derivative.iter_mut().zip(a).zip(b) {
            *d += (b - a) * value / (longer - shorter);
        }
    }
    columns.push(derivative);
    let bare = base.before_causes(&adjusted.whitened, &adjusted.solution);
    let fit = Fit::new(&bare, &columns);
    let covariance = |i: usize, k: usize| fit.covariance[i * (n + 1) + k];
    let u = if fit.seen[n] {
        covariance(n, n).sqrt()
    } else {
        f64::INFINITY
    };
    let block = (0..n * n).map(|ik| covariance(ik / n, ik % n));
    (block.collect(), u)
}
