//! What was found in one verification, as the outcome says it.

use nalgebra::DMatrix;
use trueaxis_effects::{Level, Parameter, ResolvedEffect, Scene, Shape, Subject};
use trueaxis_kinematics::AxisKind;

use crate::fitted::{Against, Fitted, Row};
use crate::selection::{Fit, Projection, cosine, is_rival};
use crate::verification::arrivals::Arrival;
use crate::verification::held_out::gain_of;
use crate::verification::lost_motion::curve;
use crate::verification::problem::{Chosen, Problem};
use crate::verification::search::{Judged, contains, judge, ln_more};
use crate::{Cause, EstimatedParameter, Place, Rival};

/// Root mean square of a column over the readings, µm.
pub(crate) fn rms_of_readings_um(problem: &Problem<'_>, column: &[f64]) -> f64 {
    let readings = &column[..problem.readings()];
    let squares: f64 = readings.iter().map(|x| x * x).sum();
    problem.sigma_um * (squares / readings.len() as f64).sqrt()
}

/// The causes with their values, rivals and gains.
pub(crate) fn causes(
    problem: &Problem<'_>,
    scene: &Scene,
    chosen: &[Chosen],
    after: &Projection,
    folds: &[usize],
) -> Vec<Cause> {
    let joint = Fit::new(&problem.base, &problem.columns(chosen));
    let variance =
        (after.squares() / after.degrees_of_freedom.max(1.0)).max(problem.least_variance);
    let total = joint.estimates.len();
    let covariance = DMatrix::from_row_slice(total, total, &joint.covariance) * variance;
    let mut first = 0;
    let mut causes = Vec::new();
    for (k, cause) in chosen.iter().enumerate() {
        let candidate = &problem.candidates[cause.candidate];
        let (effect, subject) = (candidate.hypothesis.effect, candidate.hypothesis.subject);
        let linear = effect.parameters(scene, &subject);
        let columns = problem.columns(std::slice::from_ref(cause));
        let range = first..first + columns.len();
        first = range.end;
        let Some(judged) = judge(problem, chosen, k) else {
            continue;
        };
        let values = &joint.estimates[range.clone()];
        let seen = &joint.seen[range.clone()];
        let of_columns =
            covariance.view((range.start, range.start), (columns.len(), columns.len()));
        let own = of_columns.view((0, 0), (linear.len(), linear.len()));
        let mut parameters: Vec<EstimatedParameter> = linear
            .iter()
            .enumerate()
            .map(|(i, parameter)| EstimatedParameter {
                name: parameter.name.clone(),
                value: values[i],
                // What these lines do not show has no uncertainty.
                u: match seen[i] {
                    true => own[(i, i)].max(0.0).sqrt(),
                    false => f64::INFINITY,
                },
                unit: parameter.unit,
            })
            .collect();
        let time_unit = match problem.comparison.timed {
            true => "s",
            false => "readings",
        };
        if let Some((parameter, size)) = shape_parameter(effect.shape, scene, &subject, time_unit) {
            parameters.push(EstimatedParameter {
                name: parameter.name,
                value: cause.shape / size,
                u: cause.u_shape / size,
                unit: parameter.unit,
            });
        }
        let fit = Fit::new(&judged.model, &columns);
        let curve = match columns.len() > linear.len() {
            true => curve(
                problem.comparison,
                &columns,
                values,
                &of_columns.into_owned(),
            ),
            false => Vec::new(),
        };
        causes.push(Cause {
            effect: ResolvedEffect {
                effect,
                subject,
                parameters: values[..linear.len()].to_vec(),
                shape: cause.shape,
            },
            level: Level::Verification,
            data: String::new(),
            p_value: judged.p_value,
            delta_bic: judged.score.bic,
            explained_rms_um: rms_of_readings_um(problem, &fit.explained),
            heldout_gain: gain_of(problem, chosen, k, folds)
                .map(|bounded| 1.0 - bounded.gain.heldout_rms_ratio),
            parameters,
            covariance: own.transpose().iter().copied().collect(),
            rivals: rivals(problem, chosen, k, &judged, &fit),
            changes: Vec::new(),
            share: None,
            share_of_curve: None,
            curve,
            fitted: fitted(problem, scene, &judged.model.residuals, &fit),
        });
    }
    causes
}

/// The misfit without a cause, which leaves `misfit`, and what its fit explains.
fn fitted(problem: &Problem<'_>, scene: &Scene, misfit: &[f64], fit: &Fit) -> Option<Fitted> {
    let arrivals = problem.comparison.arrivals.iter().enumerate();
    let row = |(i, arrival): (usize, &Arrival)| {
        let moving = problem.comparison.moving.iter();
        Row {
            group: 0,
            time_s: arrival.time_s,
            moving: moving
                .map(|&axis| (axis, arrival.positions[axis]))
                .collect(),
            direction: arrival.direction,
            misfit: problem.sigma_um * misfit[i],
            fitted: problem.sigma_um * fit.explained[i],
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

/// Probability of noise giving what a larger form has more, above which that is taken for absent.
const UNDECIDED: f64 = 0.1;

/// What explains the data nearly as well as cause `k`, all against the model with the other causes. A
/// form that holds the cause and more is a rival only as long as it is undecided whether there is more.
fn rivals(
    problem: &Problem<'_>,
    chosen: &[Chosen],
    k: usize,
    judged: &Judged,
    fit: &Fit,
) -> Vec<Rival> {
    let model = &judged.model;
    let cause_columns = problem.columns(&chosen[k..=k]);
    let mut rivals = Vec::new();
    for score in &judged.scores {
        let number = judged.numbers[score.scan];
        let candidate = &problem.candidates[number];
        // The same effect in another form is no rival.
        if candidate
            .hypothesis
            .is(&problem.candidates[chosen[k].candidate].hypothesis)
        {
            continue;
        }
        let columns = candidate.columns(score.shape);
        let other = Fit::new(model, columns);
        let holds_cause = score.rank > judged.score.rank
            && contains(model, &model.extended(columns), &cause_columns);
        let is_held = score.rank < judged.score.rank
            && contains(model, &model.extended(&cause_columns), columns);
        let is_close = if is_held {
            // The larger form was taken because it is decided that there is more.
            ln_more(model, score, &judged.score) > UNDECIDED.ln()
        } else if holds_cause {
            ln_more(model, &judged.score, score) < candidate.ln_level_of_more(UNDECIDED)
        } else {
            is_rival(&judged.score, score, cosine(fit, &other))
        };
        if is_close {
            rivals.push(Rival {
                effect: ResolvedEffect {
                    effect: candidate.hypothesis.effect,
                    subject: candidate.hypothesis.subject,
                    parameters: other.estimates[..candidate.parameters().len()].to_vec(),
                    shape: score.shape,
                },
                delta_bic: score.bic,
            });
        }
    }
    rivals
}

/// The shape as a parameter, and one unit of it in mm, rad or s.
///
/// Without a clock times count readings.
fn shape_parameter(
    shape: Shape,
    scene: &Scene,
    subject: &Subject,
    time_unit: &'static str,
) -> Option<(Parameter, f64)> {
    let rotary = subject
        .axis
        .is_some_and(|axis| scene.machine.axes()[axis].kind() == AxisKind::Rotary);
    match shape {
        Shape::Fixed => None,
        Shape::Instant => Some((Parameter::new("time", time_unit), 1.0)),
        Shape::TimeConstant | Shape::SettlingTime | Shape::Lag => {
            Some((Parameter::new("time_constant", time_unit), 1.0))
        }
        Shape::Period if rotary => Some((Parameter::new("period", "deg"), 1_f64.to_radians())),
        Shape::Period => Some((Parameter::new("period", "mm"), 1.0)),
        Shape::Waves => Some((Parameter::new("waves", "1"), 1.0)),
    }
}

/// Where the misfit lives: by direction and by cycle.
pub(crate) fn places(problem: &Problem<'_>, before: &Projection, after: &Projection) -> Vec<Place> {
    let arrivals = &problem.comparison.arrivals;
    let place = |by: &'static str, name: String, rows: Vec<usize>| {
        let rms = |model: &Projection| {
            let squares = rows
                .iter()
                .map(|&row| model.residuals[row].powi(2))
                .sum::<f64>();
            // The rows' share of the degrees of freedom.
            let share = model.degrees_of_freedom / problem.readings() as f64;
            problem.sigma_um * (squares / (rows.len() as f64 * share)).sqrt()
        };
        Place {
            by,
            name,
            readings: rows.len(),
            before_um: rms(before),
            after_um: rms(after),
        }
    };
    let rows_of = |f: &dyn Fn(usize) -> bool| (0..arrivals.len()).filter(|&r| f(r)).collect();
    let mut places = Vec::new();
    for (name, forward) in [("+1", true), ("-1", false)] {
        let rows: Vec<usize> = rows_of(&|row| (arrivals[row].direction > 0.0) == forward);
        places.push(place("direction", name.to_owned(), rows));
    }
    for cycle in problem.comparison.cycles() {
        let rows: Vec<usize> = rows_of(&|row| arrivals[row].cycle == cycle);
        places.push(place("cycle", cycle.to_string(), rows));
    }
    places.retain(|place| place.readings > 0);
    places
}
