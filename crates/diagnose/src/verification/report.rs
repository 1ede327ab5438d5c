//! What was found in one verification, as the outcome states it.

use trueaxis_effects::{Level, ResolvedEffect};
use trueaxis_selection::{Fit, Projection, add, combined};

use crate::engine::linear::{Chosen, Listed};
use crate::engine::{JudgedDisturbance, Misfits, side, without};
use crate::fitted::{Against, Fitted, Row};
use crate::numbers::root_mean_square;
use crate::verification::arrivals::Arrival;
use crate::verification::between_passes::variance_um2;
use crate::verification::held_out::gain_of;
use crate::verification::laser_scale;
use crate::verification::lost_motion::{curve, is_of_line, shown_along};
use crate::verification::not_at_rest;
use crate::verification::pauses::by_pauses;
use crate::verification::problem::Problem;
use crate::verification::wandering::rival_disturbances;
use crate::{Cause, Place, Rival};

/// Root mean square of a column over the readings, µm.
pub(crate) fn rms_of_readings_um(problem: &Problem<'_>, column: &[f64]) -> f64 {
    root_mean_square(&problem.um(column))
}

/// The causes with their values, rivals and gains. `predicted` leaves what the readings show beside the prediction as
/// it is; the disturbances `wandering` are beside them, and `wandered` is their effect, whitened.
pub(crate) fn causes(
    problem: &Problem<'_>,
    chosen: &[Chosen],
    (predicted, after): (&Projection, &Projection),
    (wandering, wandered): (&[JudgedDisturbance], &[f64]),
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
        let level = (problem.scene, Level::Verification);
        let by_pauses = by_pauses(
            problem,
            (chosen, wandering),
            (k, &sized.fit),
            (judged.score.two_ln_b, variance),
        );
        if let Some(by_pauses) = &by_pauses {
            by_pauses.add_to(&mut sized.fit.covariance, variance);
        }
        let is_lost_motion = is_of_line(problem.comparison, &candidate.hypothesis);
        let is_seen = columns[0].iter().any(|x| *x != 0.0) && variance > 0.0;
        if is_lost_motion && is_seen {
            // The readings differ by all of it.
            let unit_um2 = 4.0 * variance * rms_of_readings_um(problem, &columns[0]).powi(2);
            let alone_um2 = unit_um2 * sized.fit.covariance[0];
            let all_um2 = variance_um2(problem, (after, wandered), chosen, alone_um2);
            sized.fit.covariance[0] = all_um2 / unit_um2;
        }
        let u_shape = sized.u_shape.map_or(cause.u_shape, |u| u * variance.sqrt());
        let own = (&sized.fit, u_shape);
        let mut said = problem.listed.cause(&judged, level, own, variance);
        for parameter in &mut said.parameters {
            parameter.unit = problem.comparison.unit_of(parameter.unit);
        }
        let fitted = combined(predicted.rows(), &columns, &sized.fit.estimates);
        let fitted = predicted.left_of(&fitted);
        let misfit: Vec<f64> = rest.iter().zip(&fitted).map(|(a, b)| a + b).collect();
        let gain = gain_of(problem, chosen, k);
        let along_it: Vec<(f64, &[f64])> = shown_along(problem.comparison, candidate).collect();
        let (curve, mean_lost_motion) =
            curve(&along_it, &sized.fit, variance, said.parameters[0].unit);
        let explained_rms_um = rms_of_readings_um(problem, &fitted);
        let two_ln_b = judged.score.two_ln_b;
        let still_moves = not_at_rest::instead(
            problem.comparison,
            &candidate.hypothesis,
            (explained_rms_um, two_ln_b),
        );
        let by_laser = laser_scale::instead(
            problem.comparison,
            &candidate.hypothesis,
            (&sized.fit.estimates, judged.score.bic),
        );
        causes.push(Cause {
            explained_rms_um,
            heldout_gain: gain.map(|gain| 1.0 - gain.ratio.ratio),
            rivals: [
                rival_disturbances(problem, wandering, chosen, k, two_ln_b),
                problem.listed.rivals(&judged),
                by_pauses.map_or_else(Vec::new, |own| own.rivals),
                Vec::from_iter(still_moves),
                Vec::from_iter(by_laser),
            ]
            .concat(),
            curve,
            mean_lost_motion,
            fitted: shown(problem, &misfit, &fitted),
            ..said
        });
    }
    causes
}

/// The misfit without a cause, and what its fit explains.
fn shown(problem: &Problem<'_>, misfit: &[f64], fitted: &[f64]) -> Option<Fitted> {
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
    let fitted = Fitted::new(&rows, 1, |_| String::new(), problem.scene)?;
    let against = match fitted.against {
        Against::Time if !problem.comparison.timed => Against::Order,
        against => against,
    };
    Some(Fitted { against, ..fitted })
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
    let models = [before, after];
    let misfits = Misfits {
        residuals: models.map(|model| &*model.residuals),
        degrees_of_freedom: models.map(|m| m.degrees_of_freedom - problem.whitening.pseudo as f64),
        readings: problem.readings(),
        rows: 1,
        noise_um: problem.whitening.sigma_um,
    };
    let by = |name, group: &dyn Fn(&Arrival) -> (usize, String)| {
        let groups = problem.comparison.arrivals.iter().map(|a| Some(group(a)));
        misfits.places(name, groups)
    };
    [
        by("direction", &|a| side(a.direction)),
        by("cycle", &|a| (a.cycle as usize, a.cycle.to_string())),
    ]
    .concat()
}
