//! Finding the causes: one at a time, each judged against noise through the same model.
//!
//! 1. All hypotheses against what the model leaves; the one with the most evidence joins if noise alone gives one as
//!    good with less than the level (family-wise), a further cause with less than [`FURTHER_LEVEL`]. With few
//!    readings two causes of one size hide each other: two join at once, if each is as clear as a further cause.
//! 2. Of nested forms (constant play within play that changes along the axis) the larger joins only if what it has
//!    more is significant by itself.
//! 3. Shapes of all causes are sought again with the others in the model.
//! 4. Causes that have become superfluous leave, and none joins only to cancel another.
//! 5. At most one goes with time, what warms up with two time constants, or a drift and a jump that together leave
//!    nothing: several can follow any course.

use trueaxis_effects::Shape;
use trueaxis_selection::{DECISIVE, Fit, Projection, Score, ln_f_test};

use crate::engine::linear::{Beside, Chosen, Listed, without};
use crate::engine::{FURTHER_LEVEL, SHAPE_ERROR, are_opposed, fitted_effects, golden_section};

/// Most causes named: more are no longer an explanation.
pub(crate) const MOST_CAUSES: usize = 3;

/// Degrees of freedom below which one cause leaves so few for the noise that another one of its size hides it.
const FEW: f64 = 40.0;

/// Least share of a column, in squares, that must be left for one form not to contain the other.
const CONTAINED: f64 = 1e-6;

/// The causes of what the base model leaves, after the known ones, the strongest first; without superfluous ones.
pub(crate) fn search(
    listed: &Listed,
    causes: Vec<Chosen>,
    excluded: &[usize],
    level: f64,
) -> Vec<Chosen> {
    let most = causes.len() + MOST_CAUSES;
    grown(listed, causes, excluded, level, (most, true))
}

/// Up to `most` causes that begin with one, each significant beside the others, however small its share of what they
/// explain: it is more than their shape only where they leave nothing.
pub(crate) fn search_from(
    listed: &Listed,
    first: Chosen,
    excluded: &[usize],
    (level, most): (f64, usize),
) -> Vec<Chosen> {
    grown(listed, vec![first], excluded, level, (most, false))
}

/// Up to `most` causes in all; `with_shapes` one that may be no more than the shape of the others ends the search.
fn grown(
    listed: &Listed,
    mut causes: Vec<Chosen>,
    excluded: &[usize],
    level: f64,
    (most, with_shapes): (usize, bool),
) -> Vec<Chosen> {
    // Each round adds a cause, and one that another makes superfluous leaves at most once.
    for _ in 0..2 * most {
        if causes.len() == most {
            break;
        }
        let least = match causes.is_empty() {
            true => level,
            false => level.min(FURTHER_LEVEL),
        };
        let Some(next) = best(listed, &causes, excluded, (least, !with_shapes)) else {
            if causes.is_empty() && listed.base.degrees_of_freedom < FEW {
                causes = hidden_pair(listed, excluded, least);
            }
            break;
        };
        // Between two time constants one alone explains most of both.
        let is_second = causes.iter().any(|cause| cause.candidate == next.candidate);
        if with_shapes && !is_second && is_shape_of(listed, &causes, &next) {
            break;
        }
        let before = causes.clone();
        causes.push(next);
        // A single cause was judged when it joined.
        if causes.len() > 1 {
            refine(listed, &mut causes);
            let least = match is_second {
                true => least.min(SECOND_OF_TIME),
                false => least,
            };
            drop_superfluous(listed, &mut causes, least);
            if opposed(listed, &causes) {
                return before;
            }
        }
    }
    causes
}

/// Two causes that hide each other, such as a drift and the lost motion at a single position: the one with the most
/// evidence, and what is found beside it.
fn hidden_pair(listed: &Listed, excluded: &[usize], level: f64) -> Vec<Chosen> {
    let beside = listed.beside(&[]);
    let mut possible = beside.scores.iter();
    let first = possible.find(|score| !excluded.contains(&beside.numbers[score.scan]));
    let Some(first) = first.map(|score| listed.chosen(&beside, score)) else {
        return Vec::new();
    };
    let least = level.min(FURTHER_LEVEL);
    let mut pair = vec![first];
    pair.extend(best(listed, &pair, excluded, (least, false)));
    drop_superfluous(listed, &mut pair, least);
    match pair.len() == 2 && !opposed(listed, &pair) {
        true => pair,
        false => Vec::new(),
    }
}

/// Whether causes cancel each other.
pub(crate) fn opposed(listed: &Listed, causes: &[Chosen]) -> bool {
    let of_each = causes.iter().map(|cause| listed.columns_of(cause));
    let effects = fitted_effects(&listed.base, &of_each.collect::<Vec<_>>());
    are_opposed(&listed.base, &effects)
}

/// Whether a further cause may be no more than the shape of the others.
fn is_shape_of(listed: &Listed, causes: &[Chosen], next: &Chosen) -> bool {
    let model = listed.with(causes);
    let earlier = listed.base.squares() - model.squares();
    let with = model.extended(&listed.columns_of(next));
    let more = model.squares() - with.squares();
    !causes.is_empty() && more < SHAPE_ERROR * earlier
}

/// Drops causes that are not significant beside the others.
pub(crate) fn drop_superfluous(listed: &Listed, causes: &mut Vec<Chosen>, level: f64) {
    let mut k = 0;
    while k < causes.len() {
        if listed
            .judge(causes, k)
            .is_some_and(|judged| judged.beside.is_significant(&judged.score, level))
        {
            k += 1;
        } else {
            causes.remove(k);
        }
    }
}

/// Probability of noise giving a second cause in time, below which it is considered: disturbances give one sooner.
const SECOND_OF_TIME: f64 = 1e-12;

/// The next cause, if any: at most one in time, with a second time constant, or a drift and a jump where `both`;
/// several can follow any course.
fn best(
    listed: &Listed,
    causes: &[Chosen],
    excluded: &[usize],
    (level, both): (f64, bool),
) -> Option<Chosen> {
    let beside = listed.beside(causes);
    let hypothesis = |number: usize| &listed.candidates[number].hypothesis;
    let jumps = |number: usize| hypothesis(number).effect.shape == Shape::Instant;
    let of_time = causes.iter().map(|cause| cause.candidate);
    let of_time: Vec<usize> = of_time
        .filter(|&number| hypothesis(number).is_of_time())
        .collect();
    let is_one_too_many = |number: usize| match of_time.as_slice() {
        [] => false,
        // Another time constant of it.
        [one] if *one == number => false,
        [one] if both => jumps(*one) == jumps(number),
        _ => true,
    };
    let mut possible = beside.scores.clone();
    possible.retain(|score| {
        let number = beside.numbers[score.scan];
        let is_too_many = hypothesis(number).is_of_time() && is_one_too_many(number);
        !is_too_many && !excluded.contains(&number)
    });
    let leader = simplest(listed, &beside, &possible, level)?;
    let is_of_time = listed.candidate(&beside, leader).hypothesis.is_of_time();
    // Another time constant explains more once both are sought together, and is judged then.
    let is_second = of_time.contains(&beside.numbers[leader.scan]);
    let level = match is_of_time && !of_time.is_empty() && !is_second {
        true => level.min(SECOND_OF_TIME),
        false => level,
    };
    beside
        .is_significant(leader, level)
        .then(|| listed.chosen(&beside, leader))
}

/// Coverage factor of the uncertainty of a time constant, which is resolved if it is longer.
const COVERAGE: f64 = 2.0;

/// The one with the most evidence; but one whose time constant the data do not resolve is replaced by an equally
/// likely one without, such as a drift at a constant rate.
fn resolved<'s>(listed: &Listed, beside: &Beside, scores: &'s [Score]) -> Option<&'s Score> {
    let leader = scores.first()?;
    let is_resolved = |score: &Score| {
        let shape = listed.candidate(beside, score).hypothesis.effect.shape;
        let is_time = matches!(shape, Shape::TimeConstant | Shape::SettlingTime);
        !is_time || COVERAGE * score.u_shape < score.shape
    };
    let as_likely = scores
        .iter()
        .take_while(|s| leader.evidence - s.evidence < DECISIVE);
    let mut as_likely = as_likely.filter(|score| is_resolved(score));
    as_likely.next().or(Some(leader))
}

/// The leader, or the smaller form that it contains if it has nothing significant beyond it.
pub(crate) fn simplest<'s>(
    listed: &Listed,
    beside: &Beside,
    scores: &'s [Score],
    level: f64,
) -> Option<&'s Score> {
    let Beside { model, scans, .. } = beside;
    let leader = resolved(listed, beside, scores)?;
    let ln_level = listed.candidate(beside, leader).ln_level_of_more(level);
    let with = model.extended(&scans[leader.scan].columns(leader.shape));
    let mut smaller = scores[1..].iter().filter(|other| {
        other.rank < leader.rank
            && contains(model, &with, &scans[other.scan].columns(other.shape))
            && ln_more(model, other, leader) > ln_level
    });
    // In the order of their evidence.
    smaller.next().or(Some(leader))
}

/// Logarithm of the p-value of what a larger form explains beyond a smaller one that it contains.
pub(crate) fn ln_more(model: &Projection, smaller: &Score, larger: &Score) -> f64 {
    let more = larger.statistic - smaller.statistic;
    let left = model.squares() - smaller.statistic;
    let freedom = model.degrees_of_freedom - smaller.rank as f64;
    ln_f_test(more, left, larger.rank - smaller.rank, freedom)
}

/// Whether `with`, the model extended by some form, leaves nothing of columns of which `model` leaves something.
pub(crate) fn contains(model: &Projection, with: &Projection, columns: &[Vec<f64>]) -> bool {
    let left = |projection: &Projection, column: &[f64]| {
        let mut column = column.to_vec();
        projection.project(&mut column);
        column.iter().map(|x| x * x).sum::<f64>()
    };
    let is_contained = |c: &Vec<f64>| left(with, c) <= CONTAINED * left(model, c);
    columns.iter().all(is_contained)
}

/// Most rounds in which several shapes settle, and the share of itself that a settled one moves by.
const MOST_ROUNDS: usize = 12;
const RESTS: f64 = 1e-3;

/// How many times the change of a round goes on at most, and how exactly that is sought.
const FARTHEST: f64 = 20.0;
const EXACT: f64 = 0.02;

/// Seeks each shape again with the other causes in the model.
pub(crate) fn refine(listed: &Listed, causes: &mut [Chosen]) {
    let candidate = |cause: &Chosen| &listed.candidates[cause.candidate];
    for k in 0..causes.len() {
        if !candidate(&causes[k]).hypothesis.has_shape() {
            continue;
        }
        let beside = listed.beside(&without(causes, k));
        if let Some(score) = beside.score_of(&causes[k]) {
            causes[k] = listed.chosen(&beside, &score);
        }
    }
    let is_continuous = |k: &usize| candidate(&causes[*k]).is_continuous();
    let continuous: Vec<usize> = (0..causes.len()).filter(is_continuous).collect();
    if continuous.len() > 1 {
        settle_together(listed, causes, &continuous);
    }
}

/// Settles several shapes: one at a time creeps where they hide each other, as two time constants do, and goes on along
/// the change of each round (Powell 1964).
fn settle_together(listed: &Listed, causes: &mut [Chosen], continuous: &[usize]) {
    for _ in 0..MOST_ROUNDS {
        let before = causes.to_vec();
        for &k in continuous {
            let model = listed.with(&without(causes, k));
            let candidate = &listed.candidates[causes[k].candidate];
            causes[k].shape = candidate.settled(&model, causes[k].shape);
        }
        let after = causes.to_vec();
        let farther = |times: f64| {
            let mut moved = after.clone();
            for &k in continuous {
                moved[k].shape *= (after[k].shape / before[k].shape).powf(times);
            }
            moved
        };
        let explained =
            |times: f64| Fit::new(&listed.base, &listed.columns(&farther(times))).gained();
        let times = golden_section([0.0, FARTHEST], |a, b| b - a < EXACT, explained);
        if explained(times) > explained(0.0) {
            causes.copy_from_slice(&farther(times));
        }
        let moves = |&k: &usize| (causes[k].shape / before[k].shape - 1.0).abs() >= RESTS;
        if !continuous.iter().any(moves) {
            return;
        }
    }
}
