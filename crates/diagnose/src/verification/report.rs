//! What was found in one verification, as the outcome states it.

use trueaxis_effects::{Effect, Level, ResolvedEffect, Scene, Subject};
use trueaxis_selection::{DECISIVE, Fit, Projection, Score, add, combined, cosine, is_rival};

use crate::engine::linear::{Chosen, Judged, Listed, contains, ln_more, without};
use crate::engine::{places as places_by, side};
use crate::fitted::{Against, Fitted, Row};
use crate::verification::arrivals::Arrival;
use crate::verification::held_out::gain_of;
use crate::verification::lost_motion::{curve, shown_along};
use crate::verification::pauses::by_pauses;
use crate::verification::problem::Problem;
use crate::verification::wandering::{FittedProcess, rival_disturbances};
use crate::{Cause, Place, Rival};

/// Root mean square of a column over the readings, µm.
pub(crate) fn rms_of_readings_um(problem: &Problem<'_>, column: &[f64]) -> f64 {
    let readings = problem.um(column);
    let squares: f64 = readings.iter().map(|x| x * x).sum();
    (squares / readings.len() as f64).sqrt()
}

/// The causes with their values, rivals and gains. `predicted` leaves what the readings show beside the prediction as
/// it is; the disturbances `wandering` are beside them, and `wandered` is their effect, whitened.
pub(crate) fn causes(
    problem: &Problem<'_>,
    scene: &Scene,
    chosen: &[Chosen],
    (predicted, after): (&Projection, &Projection),
    (wandering, wandered): (&[FittedProcess], &[f64]),
) -> Vec<Cause> {
    let joint = Fit::new(&problem.listed.base, &problem.listed.columns(chosen));
    let variance =
        (after.squares() / after.degrees_of_freedom.max(1.0)).max(problem.least_variance);
    // What the causes and disturbances leave.
    let mut rest = joint.effect;
    add(&mut rest, wandered, 1.0);
    predicted.project(&mut rest);
    for (rest, residual) in rest.iter_mut().zip(&predicted.residuals) {
        *rest = residual - *rest;
    }
    let mut causes = Vec::new();
    let sizes = problem.listed.sizes(chosen);
    for (k, (cause, mut sized)) in chosen.iter().zip(sizes).enumerate() {
        let candidate = &problem.listed.candidates[cause.candidate];
        let columns = candidate.columns(cause.shape);
        let Some(judged) = problem.listed.judge(chosen, k) else {
            continue;
        };
        let level = (scene, Level::Verification);
        let by_pauses = by_pauses(
            problem,
            (chosen, wandering),
            (k, &sized.fit),
            (judged.score.evidence, variance),
        );
        if let Some(by_pauses) = &by_pauses {
            by_pauses.add_to(&mut sized.fit.covariance, variance);
        }
        let u_shape = sized.u_shape.map_or(cause.u_shape, |u| u * variance.sqrt());
        let own = (&sized.fit, u_shape);
        let mut said = problem.listed.cause(&judged, level, own, variance);
        for parameter in &mut said.parameters {
            parameter.unit = problem.comparison.unit_of(parameter.unit);
        }
        let mut fitted = combined(predicted.rows(), &columns, &sized.fit.estimates);
        predicted.project(&mut fitted);
        let misfit: Vec<f64> = rest.iter().zip(&fitted).map(|(a, b)| a + b).collect();
        let gain = gain_of(problem, chosen, k);
        let along_it: Vec<(f64, &[f64])> = shown_along(problem.comparison, candidate).collect();
        let (curve, mean_lost_motion) = curve(&along_it, &sized.fit, variance);
        causes.push(Cause {
            explained_rms_um: rms_of_readings_um(problem, &fitted),
            heldout_gain: gain.map(|bounded| 1.0 - bounded.gain.heldout_rms_ratio),
            rivals: [
                rival_disturbances(problem, wandering, chosen, k, judged.score.evidence),
                rivals(&problem.listed, &judged),
                by_pauses.map_or_else(Vec::new, |own| own.rivals),
            ]
            .concat(),
            curve,
            mean_lost_motion,
            fitted: shown(problem, scene, &misfit, &fitted),
            ..said
        });
    }
    causes
}

/// The misfit without a cause, and what its fit explains.
fn shown(problem: &Problem<'_>, scene: &Scene, misfit: &[f64], fitted: &[f64]) -> Option<Fitted> {
    let arrivals = problem.comparison.arrivals.iter().enumerate();
    let (misfit, fitted) = (problem.um(misfit), problem.um(fitted));
    let row = |(i, arrival): (usize, &Arrival)| {
        let moving = problem.comparison.moving.iter();
        Row {
            group: 0,
            time_s: arrival.time_s,
            moving: moving
                .map(|&axis| (axis, arrival.positions[axis]))
                .collect(),
            direction: arrival.direction,
            misfit: misfit[i],
            fitted: fitted[i],
            u: problem.reading_um(),
        }
    };
    let rows: Vec<Row> = arrivals.map(row).collect();
    let fitted = Fitted::new(&rows, |_| String::new(), scene)?;
    let against = match fitted.against {
        Against::Time if !problem.comparison.timed => Against::Order,
        against => against,
    };
    Some(Fitted { against, ..fitted })
}

/// Probability that noise gives as much as a larger form has more, above which it is taken to have no more.
const UNDECIDED: f64 = 0.1;

/// What explains the data nearly as well as a cause, each against the model with the other causes. A form that holds
/// the cause and more is a rival only while it is undecided whether there is more.
pub(crate) fn rivals(listed: &Listed, judged: &Judged) -> Vec<Rival> {
    let (model, own) = (&judged.beside.model, &judged.score);
    let cause_columns = listed.columns_of(&judged.cause);
    let mut rivals = listed.rivals(judged, |score, other, columns| {
        let holds_cause =
            score.rank > own.rank && contains(model, &model.extended(columns), &cause_columns);
        let is_held =
            score.rank < own.rank && contains(model, &model.extended(&cause_columns), columns);
        if is_held {
            // The larger form was taken because it is decided that there is more.
            ln_more(model, score, own) > UNDECIDED.ln()
        } else if holds_cause {
            let candidate = listed.candidate(&judged.beside, score);
            ln_more(model, own, score) < candidate.ln_level_of_more(UNDECIDED)
        } else {
            is_rival(own, score, cosine(&judged.fit, other))
        }
    });
    rivals.extend(lost_motion_beyond_drives(listed, judged));
    // Straight and free lost motion are one effect in two forms: the better of them is stated.
    let mut said: Vec<(&Effect, Subject)> = Vec::new();
    rivals.retain(|rival| {
        let Rival::Effect { effect, .. } = rival else {
            return true;
        };
        let name = (effect.effect, effect.subject);
        let is_new = !said.contains(&name);
        said.push(name);
        is_new
    });
    rivals
}

/// Lost motion that would explain as much if a drive lost so much: a mistake in the table is likelier than anything
/// else that reverses with the axis. Beside late time stamps it always counts: soft joints lose unlike play.
fn lost_motion_beyond_drives(listed: &Listed, judged: &Judged) -> impl Iterator<Item = Rival> {
    let (beside, own) = (&judged.beside, &judged.score);
    let effect = |score: &Score| listed.candidate(beside, score).hypothesis.effect;
    let is_late = effect(own).is_delay();
    let is_it = move |score: &&Score| {
        effect(score).is_lost_motion() && (is_late || own.evidence - score.evidence < DECISIVE)
    };
    beside.impossible.iter().filter(is_it).map(|score| {
        let columns = listed.candidate(beside, score).columns(score.shape);
        listed.rival(beside, score, &Fit::new(&beside.model, &columns))
    })
}

/// Adds to the causes of a model those of another one that is as good, each to the causes that it replaces there.
pub(crate) fn add_rivals(
    listed: &Listed,
    chosen: &[Chosen],
    others: &[Chosen],
    causes: &mut [Cause],
) {
    let has = |all: &[Chosen], one: &ResolvedEffect| {
        let mut all = all.iter().map(|own| listed.hypothesis(own));
        all.any(|own| (own.effect, own.subject) == (one.effect, one.subject))
    };
    for (k, (other, sized)) in others.iter().zip(listed.sizes(others)).enumerate() {
        let effect = listed.candidates[other.candidate].resolved(&sized.fit.estimates, other.shape);
        if has(chosen, &effect) {
            continue;
        }
        let Some(score) = listed.beside(&without(others, k)).score_of(other) else {
            continue;
        };
        for cause in causes.iter_mut() {
            let is_listed = cause.rival_effects().any(|own| own.is(&effect));
            if !has(others, &cause.effect) && !is_listed {
                cause.rivals.push(Rival::Effect {
                    effect: effect.clone(),
                    delta_bic: score.bic,
                });
            }
        }
    }
}

/// The misfit by direction and by cycle.
pub(crate) fn places(problem: &Problem<'_>, before: &Projection, after: &Projection) -> Vec<Place> {
    let rms_um = |rows: &[usize]| {
        [before, after].map(|model| {
            let squares: f64 = rows.iter().map(|&row| model.residuals[row].powi(2)).sum();
            // The rows' share of the degrees of freedom.
            let degrees_of_freedom = model.degrees_of_freedom - problem.whitening.pseudo as f64;
            let share = degrees_of_freedom / problem.readings() as f64;
            problem.whitening.sigma_um * (squares / (rows.len() as f64 * share)).sqrt()
        })
    };
    let by = |name, group: &dyn Fn(&Arrival) -> (usize, String)| {
        let groups = problem.comparison.arrivals.iter().map(|a| Some(group(a)));
        places_by(name, groups, &rms_um)
    };
    [
        by("direction", &|a| side(a.direction)),
        by("cycle", &|a| (a.cycle as usize, a.cycle.to_string())),
    ]
    .concat()
}
