//! The causes in words and units: parameters with their uncertainties ([`crate::parameters`]).

use trueaxis_effects::{Level, ResolvedEffect, Shape};

use crate::fitted::{Fitted, Row};
use crate::parameters::{beside_shape, by_shape, u_in_gap_s, with_uncertainties};
use crate::points::base::Base;
use crate::points::model::Model;
use crate::points::search::{Found, Suspect, columns_mm};
use crate::selection::{Fit, Hypothesis};
use crate::{Cause, Gain, Rival};

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
        let own = first..first + effect.parameters(base.scene, &subject).len();
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
                let stops = base.readings.stops.iter();
                let starts_s = stops.map(|stop| base.readings.span_s(stop)[0]);
                u_shape = u_shape.hypot(u_in_gap_s(starts_s, cause.suspect.shape));
            }
            Shape::TimeConstant | Shape::SettlingTime => {
                (covariance, u_shape) =
                    with_time_constant(base, model, &suspects, &cause.suspect, &values);
            }
            Shape::Fixed | Shape::Lag | Shape::Period | Shape::Waves => {}
        }
        let count = values.len();
        let u = |k: usize| match fit.seen[own.start + k] {
            true => covariance[k * count + k].max(0.0).sqrt(),
            false => f64::INFINITY,
        };
        let hypothesis = &cause.suspect.hypothesis;
        let shape = (cause.suspect.shape, u_shape);
        let parameters = with_uncertainties(base.scene, hypothesis, &values, u, shape);
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
            curve: Vec::new(),
            share_of_curve: None,
            fitted: fitted(base, model, &suspects, &cause.suspect),
        });
    }
    (causes, effects)
}

/// The misfit without a cause and what it explains, of one coordinate of one target, weighted with the noise.
fn fitted(base: &Base<'_>, model: &Model, all: &[Suspect], suspect: &Suspect) -> Option<Fitted> {
    let others = all.iter().filter(|s| !s.hypothesis.is(&suspect.hypothesis));
    let others: Vec<Suspect> = others.copied().collect();
    let without = Model::with(base, &columns_mm(base, &others), model.noise, None);
    let noise_um = model.noise.mean_um(&base.readings);
    let residuals = without.projection.residuals.iter();
    let residuals = residuals.zip(&model.projection.residuals).enumerate();
    let row = |(i, (misfit, left)): (usize, (&f64, &f64))| {
        let reading = &base.readings.all[i / 3];
        let positions = &base.campaign.steps[reading.step].positions;
        Row {
            group: 3 * reading.target + i % 3,
            time_s: reading.time_s,
            moving: reading
                .axis
                .map(|axis| (axis, positions[axis]))
                .into_iter()
                .collect(),
            direction: reading.side,
            misfit: noise_um * misfit,
            fitted: noise_um * (misfit - left),
        }
    };
    let rows: Vec<Row> = residuals.map(row).collect();
    let name = |group: usize| {
        format!(
            "a coordinate of target {}",
            base.scene.targets[group / 3].name
        )
    };
    Fitted::new(&rows, name, base.scene)
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
    let ends = [1.0 - STEP, 1.0 + STEP].map(|part| suspect.shape * part);
    let ends = ends.map(|shape| (shape, at(shape)));
    columns.push(by_shape(ends, values, base.misfit_mm.len()));
    let others = suspects
        .iter()
        .filter(|s| !s.hypothesis.is(&suspect.hypothesis));
    columns.extend(others.flat_map(|s| columns_mm(base, std::slice::from_ref(s))));
    beside_shape(&Fit::new(&model.bare, &model.whitened(base, &columns)), n)
}
