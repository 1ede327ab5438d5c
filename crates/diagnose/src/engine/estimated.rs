//! A cause with its parameters and their uncertainties.
//!
//! The data show only that an instant lies between two visits in which the effect shows, or in one of them; the
//! uncertainty of its score includes this. A time constant joins the linear parameters by its derivative, so that all
//! parameters include its uncertainty.

use trueaxis_effects::{Level, Parameter, ResolvedEffect, Scene, shape_parameter};
use trueaxis_leastsquares::dot;
use trueaxis_selection::{Fit, Hypothesis};

use crate::engine::{Found, Measured, Suspect, duration_s};
use crate::{Cause, EstimatedParameter, Fitted, Gain, Rival};

/// Size of parameters, relative to the largest of an effect, below which they are rounding.
const ROUNDING: f64 = 1e-9;

/// Step of the logarithm of a time constant for its derivative.
const STEP: f64 = 0.01;

/// A cause of a model with its parameters; `gain` if it is the only contribution to the gain.
pub(crate) fn cause<D: Measured>(
    data: &D,
    of: Level,
    model: &D::Model,
    found: &Found,
    gain: Option<Gain>,
    (explained_rms_um, fitted): (f64, Option<Fitted>),
) -> Cause {
    let (parameters, covariance) = estimated(data, model, &found.suspect);
    let effects = found.rivals.iter();
    let effects = effects.map(|(suspect, bic)| Rival::Effect {
        effect: suspect.resolved(),
        delta_bic: *bic,
    });
    let disturbances = found.wandering.iter();
    let disturbances = disturbances.map(|&(wanderer, two_ln_b)| Rival::of(of, wanderer, two_ln_b));
    Cause {
        p_value: found.p_value,
        delta_bic: found.bic,
        explained_rms_um,
        heldout_gain: gain.map(|g| 1.0 - g.heldout_rms_ratio),
        rivals: disturbances.chain(effects).collect(),
        fitted,
        ..Cause::of(of, found.suspect.resolved(), parameters, covariance)
    }
}

impl Cause {
    /// An effect with its values; its judgement is filled in later.
    pub(crate) fn of(
        level: Level,
        effect: ResolvedEffect,
        parameters: Vec<EstimatedParameter>,
        covariance: Vec<f64>,
    ) -> Self {
        Self {
            effect,
            level,
            data: Vec::new(),
            p_value: 1.0,
            delta_bic: 0.0,
            explained_rms_um: 0.0,
            heldout_gain: None,
            share: None,
            parameters,
            covariance,
            rivals: Vec::new(),
            changes: Vec::new(),
            curve: Vec::new(),
            mean_lost_motion: None,
            sizes_p_value: None,
            share_of_curve: None,
            fitted: None,
        }
    }
}

/// Values with standard uncertainties, the shape last, and the covariance of the linear ones (rows one after the
/// other). A parameter that the data do not fully see has an infinite uncertainty.
fn estimated<D: Measured>(
    data: &D,
    model: &D::Model,
    suspect: &Suspect,
) -> (Vec<EstimatedParameter>, Vec<f64>) {
    let (mut covariance, mut u_shape) = (suspect.covariance.clone(), suspect.u_shape);
    if suspect.hypothesis.effect.shape.is_duration() {
        (covariance, u_shape) = with_time_constant(data, model, suspect);
    }
    let linear = (&suspect.parameters[..], &covariance[..], &suspect.seen[..]);
    let shape = (suspect.shape, u_shape);
    let all = with_uncertainties(data.scene(), &suspect.hypothesis, linear, shape);
    (all, covariance)
}

/// Covariance of the parameters and standard uncertainty of the time constant, with all causes free.
fn with_time_constant<D: Measured>(
    data: &D,
    model: &D::Model,
    suspect: &Suspect,
) -> (Vec<f64>, f64) {
    let columns = data.columns(model);
    // For almost no lag, a step relative to the campaign.
    let least = STEP * duration_s(&data.visits());
    let with_shape = |s: &Suspect| {
        let at = |shape: f64| columns(&s.hypothesis, shape);
        let mut all = at(s.shape);
        let mut unit = None;
        if s.hypothesis.effect.shape.is_duration() {
            let step = STEP * s.shape.max(least);
            let ends = [(s.shape - step).max(0.0), s.shape + step];
            let ends = ends.map(|shape| (shape, at(shape)));
            let column = by_shape(ends, &s.parameters, D::bare(model).rows());
            if let Some(by_shape) = ByShape::new(column, &all) {
                unit = Some(by_shape.unit);
                all.push(by_shape.column);
            }
        }
        (all, unit)
    };
    let (own, unit) = with_shape(suspect);
    let Some(unit) = unit else {
        return (suspect.covariance.clone(), f64::INFINITY);
    };
    let others = D::suspects(model).iter().filter(|s| !s.is(suspect));
    let others: Vec<Vec<f64>> = others.flat_map(|s| with_shape(s).0).collect();
    let fit = Fit::new(&D::bare(model).extended(&others), &own);
    beside_shape(&fit, own.len() - 1, unit)
}

/// Parameters of a hypothesis: the linear ones with their values, covariance (rows one after the other), and whether
/// the data fully see each, then the shape with its value and standard uncertainty.
pub(crate) fn with_uncertainties(
    scene: &Scene,
    hypothesis: &Hypothesis,
    (values, covariance, seen): (&[f64], &[f64], &[bool]),
    (shape, u_shape): (f64, f64),
) -> Vec<EstimatedParameter> {
    let u = |k: usize| match seen[k] {
        true => covariance[k * values.len() + k].max(0.0).sqrt(),
        false => f64::INFINITY,
    };
    let largest = values
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    // Values that are not seen at all are rounding.
    let value = |k: usize| match seen[k] || values[k].abs() > ROUNDING * largest {
        true => values[k],
        false => 0.0,
    };
    let linear = hypothesis.parameters(scene).into_iter().enumerate();
    let linear = linear.map(|(k, parameter)| (parameter, value(k), u(k)));
    let of_shape = shape_parameter(hypothesis.effect, scene, &hypothesis.subject);
    let of_shape = of_shape.map(|p| match p.unit {
        "deg" => (p, shape.to_degrees(), u_shape.to_degrees()),
        _ => (p, shape, u_shape),
    });
    let estimated = |(parameter, value, u): (Parameter, f64, f64)| EstimatedParameter {
        name: parameter.name,
        value,
        u,
        unit: parameter.unit,
    };
    linear.chain(of_shape).map(estimated).collect()
}

/// Derivative of the observations by a shape, from the columns for a shorter and a longer one.
fn by_shape([shorter, longer]: [(f64, Vec<Vec<f64>>); 2], values: &[f64], rows: usize) -> Vec<f64> {
    let mut derivative = vec![0.0; rows];
    for ((a, b), value) in shorter.1.iter().zip(&longer.1).zip(values) {
        for ((d, a), b) in derivative.iter_mut().zip(a).zip(b) {
            *d += (b - a) * value / (longer.0 - shorter.0);
        }
    }
    derivative
}

/// Relative difference of shapes for the derivative of a closed form: half of the digits are left.
const DIFFERENCE: f64 = 1e-5;

/// The derivative of an effect with these values by its shape, from columns in closed form.
pub(crate) fn derivative(
    columns_at: impl Fn(f64) -> Vec<Vec<f64>>,
    values: &[f64],
    shape: f64,
) -> Vec<f64> {
    let h = shape * DIFFERENCE;
    let ends = [shape - h, shape + h].map(|shape| (shape, columns_at(shape)));
    let rows = ends[0].1.first().map_or(0, Vec::len);
    by_shape(ends, values, rows)
}

/// The effect of a shape as a column beside those of the parameters.
pub(crate) struct ByShape {
    /// As long as the longest of these: in another unit, what the data show of parameters would count as rounding.
    pub(crate) column: Vec<f64>,
    /// Change of the shape for a unit of the column.
    pub(crate) unit: f64,
}

impl ByShape {
    /// From the derivative with respect to the shape; `None` if the shape changes nothing.
    pub(crate) fn new(derivative: Vec<f64>, columns: &[Vec<f64>]) -> Option<Self> {
        let squares = columns.iter().map(|column| dot(column, column));
        let unit = (squares.fold(0.0, f64::max) / dot(&derivative, &derivative)).sqrt();
        unit.is_finite().then(|| Self {
            column: derivative.iter().map(|d| d * unit).collect(),
            unit,
        })
    }
}

/// Covariance of the first `n` parameters of a fit, and the standard uncertainty of the shape, whose column
/// ([`ByShape`]) is the next one.
pub(super) fn beside_shape(fit: &Fit, n: usize, unit: f64) -> (Vec<f64>, f64) {
    let width = fit.seen.len();
    let u = match fit.seen[n] {
        true => fit.covariance[n * width + n].sqrt() * unit,
        false => f64::INFINITY,
    };
    (fit.part(0..n).covariance, u)
}
