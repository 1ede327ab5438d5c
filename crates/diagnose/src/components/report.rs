//! An effect on a curve as a cause of the diagnosis.

use nalgebra::DVector;
use trueaxis_effects::{Level, Scene, Shape};
use trueaxis_kinematics::{ARCSEC, MICROMETRE};
use trueaxis_selection::Fit;

use crate::cause::{Cause, EstimatedParameter};
use crate::components::candidates::is_shortest;
use crate::components::curve_set::CurveSet;
use crate::components::search::Found;
use crate::engine::with_uncertainties;
use crate::fitted::{Fitted, Row};
use crate::numbers::squares;

/// Lever by which angles enter an rms of displacements, mm: the size of a workpiece.
const LEVER_MM: f64 = 100.0;

/// Relative difference of the parameters for the derivatives of amplitude and phase.
const DIFFERENCE: f64 = 1e-6;

pub(crate) fn cause(set: &CurveSet, found: &Found, scene: &Scene) -> Cause {
    let hypothesis = &found.candidate.hypothesis;
    let estimate = &found.estimate;
    let n = estimate.parameters.len();
    // Waves of two steps may as well be shorter: the period is an upper limit, without an uncertainty.
    let has_period = hypothesis.effect.shape == Shape::Period;
    let u_shape = match has_period && is_shortest(set, estimate.shape) {
        true => f64::INFINITY,
        false => estimate.u_shape,
    };
    let of_shape = (estimate.shape, u_shape);
    let covariance: Vec<f64> = (0..n * n)
        .map(|k| estimate.covariance[(k / n, k % n)])
        .collect();
    let columns = set.columns(&found.candidate, estimate.shape);
    let seen = Fit::new(&set.after_gauge(set.values.clone()), &columns).seen;
    let linear = (&estimate.parameters[..], &covariance[..], &seen[..]);
    let mut parameters = with_uncertainties(scene, hypothesis, linear, of_shape);
    let unit = parameters.first().map_or("um", |parameter| parameter.unit);
    let derived = amplitude_and_phase(found, unit, seen.iter().all(|seen| *seen));
    parameters.splice(n..n, derived);
    let (share, rms_um) = share_and_rms(set, &estimate.curve);
    let effect = hypothesis.resolved(estimate.parameters.clone(), estimate.shape);
    Cause {
        data: vec!["error curves".to_owned()],
        p_value: found.p_value,
        delta_bic: found.score.bic,
        explained_rms_um: rms_um,
        rivals: found.rivals.clone(),
        share_of_curve: Some(share),
        fitted: fitted(set, &estimate.curve, scene),
        ..Cause::of(Level::Components, effect, parameters, covariance)
    }
}

/// `s sin + c cos = A sin(… + φ)` has `A = √(s² + c²)` and `φ = atan2(c, s)`. In two directions the point moves on an
/// ellipse, the sum of two circles in opposite senses; A is the sum of their radii, half its long axis. Of waves of
/// two steps the positions show one fixed phase, and only the part of the amplitude in this phase.
fn amplitude_and_phase(
    found: &Found,
    unit: &'static str,
    is_seen: bool,
) -> Vec<EstimatedParameter> {
    let values = &found.estimate.parameters;
    let given = |name: &str, f: &dyn Fn(&[f64]) -> f64, unit| EstimatedParameter {
        name: name.to_owned(),
        value: f(values),
        u: match is_seen {
            true => u_of(found, f),
            false => f64::INFINITY,
        },
        unit,
    };
    match values.len() {
        2 => {
            let amplitude = given("amplitude", &|v| v[0].hypot(v[1]), unit);
            let phase = |v: &[f64]| v[1].atan2(v[0]).to_degrees();
            let phase = is_seen.then(|| given("phase", &phase, "deg"));
            [amplitude].into_iter().chain(phase).collect()
        }
        4 => {
            let long = |v: &[f64]| {
                0.5 * ((v[1] + v[2]).hypot(v[3] - v[0]) + (v[1] - v[2]).hypot(v[3] + v[0]))
            };
            vec![given("amplitude", &long, unit)]
        }
        _ => Vec::new(),
    }
}

/// Standard uncertainty of a function of the parameters, to first order.
fn u_of(found: &Found, f: &dyn Fn(&[f64]) -> f64) -> f64 {
    let values = &found.estimate.parameters;
    let h = (DIFFERENCE * squares(values).sqrt()).max(f64::MIN_POSITIVE.sqrt());
    let slope = |k: usize| {
        let (mut above, mut below) = (values.clone(), values.clone());
        above[k] += h;
        below[k] -= h;
        (f(&above) - f(&below)) / (2.0 * h)
    };
    let gradient = DVector::from_fn(values.len(), |k, _| slope(k));
    (gradient.transpose() * &found.estimate.covariance * &gradient)[(0, 0)]
        .max(0.0)
        .sqrt()
}

/// The curve of the set with the largest effect, both after the gauge.
fn fitted(set: &CurveSet, effect: &[f64], scene: &Scene) -> Option<Fitted> {
    let [values, effect] = [&set.values[..], effect].map(|y| set.after_gauge(y.to_vec()).residuals);
    let row = |(i, (misfit, fitted))| {
        let (position, direction) = set.nodes[i % set.nodes.len()];
        Row {
            group: i / set.nodes.len(),
            time_s: 0.0,
            moving: vec![(set.axis, position)],
            direction,
            misfit,
            fitted,
            u: set.covariance[(i, i)].max(0.0).sqrt(),
        }
    };
    let values = values.into_iter().zip(effect).enumerate();
    let rows: Vec<Row> = values.map(row).collect();
    let name = |k: usize| set.components[k].name(set.content.name());
    let fitted = Fitted::new(&rows, 1, name, scene)?;
    Some(fitted.of_angles(set.components[0].is_angular()))
}

/// The squares of the effect as a share of those of the curves, and its rms, both after the gauge. The drop of the squares
/// without it would depend on how a wave lies to a slope.
fn share_and_rms(set: &CurveSet, effect: &[f64]) -> (f64, f64) {
    let all = set.after_gauge(set.values.clone()).squares();
    let own = set.after_gauge(effect.to_vec()).squares();
    let share = (own / all.max(f64::MIN_POSITIVE)).min(1.0);
    let own = own / effect.len().max(1) as f64;
    let um = if set.components[0].is_angular() {
        ARCSEC * LEVER_MM / MICROMETRE
    } else {
        1.0
    };
    (share, own.sqrt() * um)
}
