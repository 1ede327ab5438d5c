//! The parameters of a cause of the lengths with their uncertainties ([`crate::parameters`]).

use trueaxis_effects::Shape;

use crate::EstimatedParameter;
use crate::lengths::base::{Adjusted, Base, Suspect};
use crate::lengths::hypotheses::{duration_s, visit_times};
use crate::parameters::{beside_shape, by_shape, u_in_gap_s, with_uncertainties};
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
    let n = suspect.parameters.len();
    let mut covariance = suspect.covariance.clone();
    let mut u_shape = suspect.u_shape;
    match hypothesis.effect.shape {
        Shape::Instant => {
            let visits = visit_times(base);
            let starts_s = visits.iter().map(|visit| visit.span_s[0]);
            u_shape = u_shape.hypot(u_in_gap_s(starts_s, suspect.shape));
        }
        Shape::TimeConstant | Shape::SettlingTime | Shape::Lag => {
            (covariance, u_shape) = with_time_constant(base, adjusted, suspect);
        }
        Shape::Fixed | Shape::Period | Shape::Waves => {}
    }
    let u = |k: usize| match suspect.seen.get(k) {
        Some(false) => f64::INFINITY,
        _ => covariance[k * n + k].max(0.0).sqrt(),
    };
    let shape = (suspect.shape, u_shape);
    let all = with_uncertainties(&base.scene, &hypothesis, &suspect.parameters, u, shape);
    (all, covariance)
}

/// Covariance of the parameters and standard uncertainty of the time constant, all free together.
fn with_time_constant(base: &Base<'_>, adjusted: &Adjusted, suspect: &Suspect) -> (Vec<f64>, f64) {
    let at = |shape: f64| base.columns(adjusted, &suspect.hypothesis, shape);
    let mut columns = at(suspect.shape);
    let n = columns.len();
    // Of a lag that is almost none, a part of the campaign.
    let step = STEP * suspect.shape.max(STEP * duration_s(&visit_times(base)));
    let ends = [(suspect.shape - step).max(0.0), suspect.shape + step];
    let ends = ends.map(|shape| (shape, at(shape)));
    columns.push(by_shape(ends, &suspect.parameters, base.readings.len()));
    let bare = base.before_causes(&adjusted.whitened, &adjusted.solution);
    beside_shape(&Fit::new(&bare, &columns), n)
}
