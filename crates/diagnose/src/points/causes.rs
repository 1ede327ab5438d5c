//! The causes in words and units: parameters with their uncertainties.
//!
//! Of an instant the points say that it lies between two stops: it is uniform over that gap, whatever the likelihood
//! says of its neighbours. A time constant joins the linear parameters by its derivative.

use trueaxis_effects::{Level, ResolvedEffect, Shape, shape_parameter};

use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::search::{Found, Suspect, columns_mm};
use crate::selection::{Fit, Hypothesis};
use crate::{Cause, EstimatedParameter, Gain, Rival};

/// The causes with their parameters, and as effects with values.
pub(crate) fn causes(
    base: &Base<'_>,
    model: &Model,
    found: Vec<Found>,
    gain: Option<Gain>,
) -> (Vec<Cause>, Vec<ResolvedEffect>) {
    let suspects: Vec<Suspect> = found.iter().map(|f| f.suspect).collect();
    let whitened = model.whitened(base, &columns_mm(base, &suspects));
    let fit = Fit::new(&model.bare, &whitened);
    let width = whitened.len();
    let only = found.len() == 1;
    let (mut causes, mut effects, mut first) = (Vec::new(), Vec::new(), 0);
    for cause in found {
        let Hypothesis {
            effect, subject, ..
        } = cause.suspect.hypothesis;
        let linear = effect.parameters(base.scene, &subject);
        let own = first..first + linear.len();
        first = own.end;
        let values = fit.estimates[own.clone()].to_vec();
        let mut covariance: Vec<f64> = own
            .clone()
            .flat_map(|i| own.clone().map(move |k| (i, k)))
            .map(|(i, k)| fit.covariance[i * width + k])
            .collect();
        let mut u_shape = cause.suspect.u_shape;
        match effect.shape {
            Shape::Instant => {
                let gap_s = gap_s(base, cause.suspect.shape);
                u_shape = u_shape.hypot(gap_s / 12_f64.sqrt());
            }
            Shape::TimeConstant | Shape::SettlingTime => {
                let (with_shape, u) =
                    with_time_constant(base, model, &suspects, &cause.suspect, &values);
                covariance = with_shape;
                u_shape = u;
            }
            Shape::Fixed | Shape::Lag | Shape::Period | Shape::Waves => {}
        }
        let count = values.len();
        let mut parameters: Vec<EstimatedParameter> = Vec::new();
        for (k, parameter) in linear.into_iter().enumerate() {
            let is_seen = fit.seen[own.start + k];
            parameters.push(EstimatedParameter {
                name: parameter.name,
                value: values[k],
                u: match is_seen {
                    true => covariance[k * count + k].max(0.0).sqrt(),
                    false => f64::INFINITY,
                },
                unit: parameter.unit,
            });
        }
        if let Some(shape) = shape_parameter(effect, base.scene, &subject) {
            parameters.push(EstimatedParameter {
                name: shape.name,
                value: cause.suspect.shape,
                u: u_shape,
                unit: shape.unit,
            });
        }
        let resolved = ResolvedEffect {
            effect,
            subject,
            parameters: values,
            shape: cause.suspect.shape,
        };
        let alone = std::slice::from_ref(&resolved);
        let squares: f64 = (0..base.readings.all.len())
            .map(|i| base.effect_mm(i, alone).norm_squared())
            .sum();
        let rows = base.misfit_mm.len() as f64;
        let rival = |(effect, bic): (ResolvedEffect, f64)| Rival {
            effect,
            delta_bic: bic,
        };
        effects.push(resolved.clone());
        causes.push(Cause {
            effect: resolved,
            level: Level::Points,
            data: String::new(),
            p_value: cause.p_value,
            delta_bic: cause.bic,
            explained_rms_um: (squares / rows).sqrt() * 1e3,
            heldout_gain: gain.filter(|_| only).map(|g| 1.0 - g.heldout_rms_ratio),
            share: None,
            parameters,
            covariance,
            rivals: cause.rivals.into_iter().map(rival).collect(),
            changes: Vec::new(),
            share_of_curve: None,
        });
    }
    (causes, effects)
}

/// From the start of the stop before an instant to the start of the one after it, s.
fn gap_s(base: &Base<'_>, instant_s: f64) -> f64 {
    let starts = || {
        base.readings
            .stops
            .iter()
            .map(|stop| base.readings.span_s(stop)[0])
    };
    let before = starts()
        .filter(|&t| t <= instant_s)
        .fold(f64::NEG_INFINITY, f64::max);
    let after = starts()
        .filter(|&t| t > instant_s)
        .fold(f64::INFINITY, f64::min);
    match before.is_finite() && after.is_finite() {
        true => after - before,
        false => 0.0,
    }
}

/// Step of the logarithm of a time constant for its derivative.
const STEP: f64 = 0.01;

/// Covariance of the parameters and standard uncertainty of a time constant, all free together.
fn with_time_constant(
    base: &Base<'_>,
    model: &Model,
    suspects: &[Suspect],
    suspect: &Suspect,
    values: &[f64],
) -> (Vec<f64>, f64) {
    let at = |shape: f64| base.columns_mm(&suspect.hypothesis, shape);
    let mut columns = at(suspect.shape);
    let n = columns.len();
    let (shorter, longer) = (suspect.shape * (1.0 - STEP), suspect.shape * (1.0 + STEP));
    let mut derivative = vec![0.0; base.misfit_mm.len()];
    for ((a, b), value) in at(shorter).iter().zip(&at(longer)).zip(values) {
        for ((d, a), b) in derivative.iter_mut().zip(a).zip(b) {
            *d += (b - a) * value / (longer - shorter);
        }
    }
    columns.push(derivative);
    let others = suspects
        .iter()
        .filter(|s| !s.hypothesis.is(&suspect.hypothesis));
    columns.extend(others.flat_map(|s| columns_mm(base, std::slice::from_ref(s))));
    let fit = Fit::new(&model.bare, &model.whitened(base, &columns));
    let width = columns.len();
    let u = match fit.seen[n] {
        true => fit.covariance[n * width + n].sqrt(),
        false => f64::INFINITY,
    };
    let block = (0..n * n).map(|ik| fit.covariance[ik / n * width + ik % n]);
    (block.collect(), u)
}
