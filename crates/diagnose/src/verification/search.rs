//! Finding the causes: one at a time, each judged against noise through the same model.
//!
//! 1. All hypotheses against what the model leaves; the one with the most evidence joins if noise alone
//!    gives one as good with less than the level (family-wise).
//! 2. Of nested forms (constant play within play that changes along the axis) the larger joins only if
//!    what it has more is significant by itself.
//! 3. Shapes of all causes are looked for again with the others in the model.
//! 4. Causes that have become superfluous leave.

use crate::selection::{Null, Projection, SHAPE_ERROR, Scan, Score, ln_f_test, rank};
use crate::verification::problem::{Chosen, Problem};

/// Causes named at most: more are no longer an explanation.
pub(crate) const MOST_CAUSES: usize = 3;

/// What must be left of a column, in squares, for one form not to hold the other.
const CONTAINED: f64 = 1e-6;

/// The causes of what the base model leaves, the strongest first.
pub(crate) fn search(problem: &Problem<'_>, excluded: &[usize], level: f64) -> Vec<Chosen> {
    let mut causes: Vec<Chosen> = Vec::new();
    // Each round adds a cause; one that another makes superfluous gives its place free once.
    for _ in 0..2 * MOST_CAUSES {
        if causes.len() == MOST_CAUSES {
            break;
        }
        let Some(next) = best(problem, &causes, excluded, level) else {
            break;
        };
        if causes.contains(&next) {
            break;
        }
        if is_shape_of(problem, &causes, &next) {
            break;
        }
        causes.push(next);
        refine(problem, &mut causes);
        // A single cause was judged when it joined.
        if causes.len() > 1 {
            drop_superfluous(problem, &mut causes, level);
        }
    }
    causes
}

/// Whether a further cause may be no more than the shape of the others.
fn is_shape_of(problem: &Problem<'_>, causes: &[Chosen], next: &Chosen) -> bool {
    let model = problem.with(causes);
    let earlier = problem.base.squares() - model.squares();
    let columns = problem.columns(std::slice::from_ref(next));
    let more = model.squares() - model.extended(&columns).squares();
    !causes.is_empty() && more < SHAPE_ERROR * earlier
}

/// Drops causes that are not significant beside the others.
pub(crate) fn drop_superfluous(problem: &Problem<'_>, causes: &mut Vec<Chosen>, level: f64) {
    let mut k = 0;
    while k < causes.len() {
        if judge(problem, causes, k).is_some_and(|judged| judged.p_value < level) {
            k += 1;
        } else {
            causes.remove(k);
        }
    }
}

/// A cause against the model with the others.
pub(crate) struct Judged {
    /// Its score.
    pub(crate) score: Score,
    /// Family-wise p-value.
    pub(crate) p_value: f64,
    /// All scores of that model, the one with the most evidence first.
    pub(crate) scores: Vec<Score>,
    /// Candidate of each scan that the scores refer to.
    pub(crate) numbers: Vec<usize>,
    /// The model without the cause.
    pub(crate) model: Projection,
}

/// Cause `k` if the others are in the model; `None` if they leave nothing of it.
pub(crate) fn judge(problem: &Problem<'_>, causes: &[Chosen], k: usize) -> Option<Judged> {
    let others = without(causes, k);
    let model = problem.with(&others);
    let (scans, numbers) = problem.scans(&model, &others);
    let scan = numbers.iter().position(|&n| n == causes[k].candidate)?;
    let null = Null::simulated(&model, &scans);
    let mut scores = rank(&model, &scans);
    scores.retain(|score| problem.candidates[numbers[score.scan]].is_possible(&model, score.shape));
    let score = *scores.iter().find(|score| score.scan == scan)?;
    Some(Judged {
        score,
        p_value: null.family_wise(score.ln_p),
        scores,
        numbers,
        model,
    })
}

/// All causes but one.
pub(crate) fn without(causes: &[Chosen], k: usize) -> Vec<Chosen> {
    let others = causes.iter().enumerate().filter(|(i, _)| *i != k);
    others.map(|(_, cause)| *cause).collect()
}

/// The next cause, if there is one.
fn best(
    problem: &Problem<'_>,
    causes: &[Chosen],
    excluded: &[usize],
    level: f64,
) -> Option<Chosen> {
    let model = problem.with(causes);
    let (scans, numbers) = problem.scans(&model, causes);
    if scans.is_empty() {
        return None;
    }
    let mut possible = rank(&model, &scans);
    let has_time = causes
        .iter()
        .any(|cause| problem.candidates[cause.candidate].is_of_time());
    possible.retain(|score| {
        let candidate = &problem.candidates[numbers[score.scan]];
        let of_time = has_time && candidate.is_of_time();
        !of_time
            && !excluded.contains(&numbers[score.scan])
            && candidate.is_possible(&model, score.shape)
    });
    let ln_level =
        |leader: &Score| problem.candidates[numbers[leader.scan]].ln_level_of_more(level);
    let leader = simplest(&model, &scans, &possible, ln_level)?;
    let null = Null::simulated(&model, &scans);
    (null.family_wise(leader.ln_p) < level).then(|| chosen(&numbers, leader))
}

/// The leader, or the smaller form that it contains if it has nothing significant beyond it, at the level that is told.
fn simplest<'s>(
    model: &Projection,
    scans: &[Box<dyn Scan>],
    scores: &'s [Score],
    ln_level: impl Fn(&Score) -> f64,
) -> Option<&'s Score> {
    let leader = scores.first()?;
    let ln_level = ln_level(leader);
    let with = model.extended(&scans[leader.scan].columns(leader.shape));
    let smaller = scores[1..].iter().filter(|other| {
        other.rank < leader.rank
            && contains(model, &with, &scans[other.scan].columns(other.shape))
            && ln_more(model, other, leader) > ln_level
    });
    smaller
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))
        .or(Some(leader))
}

/// Logarithm of the p-value of what a larger form explains beyond a smaller one that it holds.
pub(crate) fn ln_more(model: &Projection, smaller: &Score, larger: &Score) -> f64 {
    let more = larger.statistic - smaller.statistic;
    let left = model.squares() - smaller.statistic;
    let freedom = model.degrees_of_freedom - smaller.rank as f64;
    ln_f_test(more, left, larger.rank - smaller.rank, freedom)
}

/// Whether `with`, the model extended by some form, leaves nothing of columns that `model` leaves
/// something of.
pub(crate) fn contains(model: &Projection, with: &Projection, columns: &[Vec<f64>]) -> bool {
    let left = |projection: &Projection, column: &[f64]| {
        let mut column = column.to_vec();
        projection.project(&mut column);
        column.iter().map(|x| x * x).sum::<f64>()
    };
    columns
        .iter()
        .all(|c| left(with, c) <= CONTAINED * left(model, c))
}

/// Looks for each shape again with the other causes in the model.
fn refine(problem: &Problem<'_>, causes: &mut [Chosen]) {
    if causes.len() < 2 {
        return;
    }
    for k in 0..causes.len() {
        if !problem.candidates[causes[k].candidate]
            .hypothesis
            .has_shape()
        {
            continue;
        }
        let others = without(causes, k);
        let model = problem.with(&others);
        let (scans, numbers) = problem.scans(&model, &others);
        let own = |score: &&Score| numbers[score.scan] == causes[k].candidate;
        if let Some(score) = rank(&model, &scans).iter().find(own) {
            causes[k] = chosen(&numbers, score);
        }
    }
}

fn chosen(numbers: &[usize], score: &Score) -> Chosen {
    Chosen {
        candidate: numbers[score.scan],
        shape: score.shape,
        u_shape: score.u_shape,
    }
}
