//! The search for causes where nothing is adjusted anew: every hypothesis is compared with what a model leaves of
//! readings ([`Listed`]).
//!
//! - With few readings two causes of one size hide each other: two join at once, if each is as clear as a further cause.
//! - Of nested forms (constant play within play that changes along the axis) the larger joins only if what it has
//!   more is significant by itself.
//! - At most one goes with time, what warms up with two time constants, or a drift and a jump that together leave
//!   nothing: several can follow any course.

use trueaxis_effects::Shape;
use trueaxis_selection::{DECISIVE, Fit, Projection, Score, ln_f_test};

use crate::Error;
use crate::engine::forward::{self, Forward, RESTS, is_another, select};
use crate::engine::linear::{Beside, Chosen, Judged, Listed};
use crate::engine::{FURTHER_LEVEL, SHAPE_ERROR, fitted_effects, golden_section, without};
use crate::numbers::squares;

/// Most causes named: more are no longer an explanation.
pub(crate) const MOST_CAUSES: usize = 3;

/// Degrees of freedom below which one cause leaves so few for the noise that another one of its size hides it.
const FEW: f64 = 40.0;

/// Least share of a column, in squares, that must be left for one form not to contain the other.
const CONTAINED: f64 = 1e-6;

/// Probability of noise giving a second cause in time, below which it is considered: disturbances give one sooner.
const SECOND_OF_TIME: f64 = 1e-12;

/// A search among listed hypotheses.
#[derive(Clone, Copy)]
pub(crate) struct Among<'s, 'a> {
    pub(crate) listed: &'s Listed<'a>,
    /// Candidates that are not considered.
    pub(crate) excluded: &'s [usize],
    /// Level of a cause alone, and of one beside others.
    pub(crate) level: f64,
    pub(crate) further: f64,
    pub(crate) most: usize,
    /// Whether the causes are to leave nothing: each may then be small against the others, for it is more than their
    /// shape, and a drift and a jump may be both there.
    pub(crate) is_whole: bool,
    /// Whether causes that are revised may give way to better ones.
    pub(crate) exchanges: bool,
}

impl<'s, 'a> Among<'s, 'a> {
    /// All hypotheses at a level.
    pub(crate) fn all(listed: &'s Listed<'a>, level: f64) -> Self {
        Self {
            listed,
            excluded: &[],
            level,
            further: level.min(FURTHER_LEVEL),
            most: MOST_CAUSES,
            is_whole: false,
            exchanges: true,
        }
    }

    /// The same, where no cause gives way to another, but for a form of it with fewer parameters.
    pub(crate) fn by_name(listed: &'s Listed<'a>, level: f64) -> Self {
        Self {
            exchanges: false,
            ..Self::all(listed, level)
        }
    }

    /// The causes of what the base model leaves, after these.
    pub(crate) fn after(&self, causes: Vec<Chosen>) -> Vec<Chosen> {
        select(self, causes).map_or_else(|_| Vec::new(), |selected| selected.adjusted)
    }

    /// The causes that are significant beside the others, with their shapes sought again.
    pub(crate) fn revised(&self, causes: Vec<Chosen>) -> Vec<Chosen> {
        forward::revise(self, causes).map_or_else(|_| Vec::new(), |(_, revised)| revised)
    }

    /// The best explanation beside causes at a level: at most one in time, with a second time constant, or a drift and
    /// a jump where both may be there; several can follow any course.
    fn leader(&self, beside: &Beside, causes: &[Chosen], own: Option<&Chosen>) -> Option<Score> {
        let listed = self.listed;
        let level = match causes.is_empty() {
            true => self.level,
            false => self.further,
        };
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
            [one] if self.is_whole => jumps(*one) == jumps(number),
            _ => true,
        };
        // Lost motion that changes along the axis stays only if the change shows.
        let is_form = |number: usize, own: usize| {
            let [form, it] = [number, own].map(hypothesis);
            let are_lost_motion = form.effect.is_lost_motion() && it.effect.is_lost_motion();
            let [parameters, of_it] = [number, own].map(|k| listed.candidates[k].plausible.len());
            number == own || are_lost_motion && form.subject == it.subject && parameters < of_it
        };
        let mut possible = beside.scores.clone();
        possible.retain(|score| {
            let number = beside.numbers[score.scan];
            let is_too_many = hypothesis(number).is_of_time() && is_one_too_many(number);
            match own {
                Some(own) if !self.exchanges => is_form(number, own.candidate),
                _ => !is_too_many && !self.excluded.contains(&number),
            }
        });
        let leader = simplest(listed, beside, &possible, level)?;
        let leader = plain(listed, beside, &possible, leader);
        let is_of_time = listed.candidate(beside, leader).hypothesis.is_of_time();
        // A second cause in time must be plain beside the first; another time constant explains more once both are
        // sought together, and is judged then.
        let is_second = of_time.contains(&beside.numbers[leader.scan]);
        let level = match is_of_time && !of_time.is_empty() && (own.is_some() || !is_second) {
            true => level.min(SECOND_OF_TIME),
            false => level,
        };
        beside.is_significant(leader, level).then_some(*leader)
    }
}

impl Forward for Among<'_, '_> {
    type Cause = Chosen;
    type Found = Judged;
    type Model = Vec<Chosen>;

    fn most(&self) -> usize {
        self.most
    }

    fn fit(&self, causes: Vec<Chosen>) -> Result<Vec<Chosen>, Error> {
        Ok(causes)
    }

    fn causes(model: &Vec<Chosen>) -> &[Chosen] {
        model
    }

    fn best(&self, model: &Vec<Chosen>, own: Option<&Chosen>) -> Option<Judged> {
        let beside = self.listed.beside(model);
        let score = self.leader(&beside, model, own)?;
        let cause = self.listed.chosen(&beside, &score);
        Some(self.listed.judged(beside, cause, score))
    }

    fn cause(found: &Judged) -> &Chosen {
        &found.cause
    }

    fn statistic(found: &Judged) -> f64 {
        found.score.statistic
    }

    fn has_moved(before: &Chosen, now: &Chosen) -> bool {
        let is_same = now.candidate == before.candidate;
        !is_same || is_another(before.shape, (now.shape, now.u_shape))
    }

    /// Such as a drift and the lost motion at a single position: the one with the largest 2 ln B, and what is found
    /// beside it.
    fn hidden(&self) -> Vec<Chosen> {
        let beside = self.listed.beside(&[]);
        let mut possible = beside.scores.iter();
        let first = possible.find(|score| !self.excluded.contains(&beside.numbers[score.scan]));
        let few = self.listed.base.degrees_of_freedom < FEW;
        let Some(first) = first.filter(|_| few) else {
            return Vec::new();
        };
        let first = self.listed.chosen(&beside, first);
        let second = self.best(&vec![first], None);
        std::iter::once(first)
            .chain(second.map(|second| second.cause))
            .collect()
    }

    fn seek_together(&self, causes: &mut [Chosen]) {
        let is_continuous =
            |k: &usize| self.listed.candidates[causes[*k].candidate].is_continuous();
        let continuous: Vec<usize> = (0..causes.len()).filter(is_continuous).collect();
        if continuous.len() > 1 {
            refine_together(self.listed, causes, &continuous);
        }
    }

    fn shape_error(&self) -> f64 {
        if self.is_whole { 0.0 } else { SHAPE_ERROR }
    }

    fn effects<'m>(&'m self, model: &'m Vec<Chosen>) -> Option<(&'m Projection, Vec<Vec<f64>>)> {
        let base = &self.listed.base;
        let of_each = model.iter().map(|cause| self.listed.columns_of(cause));
        Some((base, fitted_effects(base, &of_each.collect::<Vec<_>>())))
    }
}

/// Coverage factor of the uncertainty of a time constant, which is resolved if it is longer.
const COVERAGE: f64 = 2.0;

/// The one with the largest 2 ln B; but one whose time constant the data do not resolve is replaced by an equally
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
        .take_while(|s| leader.two_ln_b - s.two_ln_b < DECISIVE);
    let mut as_likely = as_likely.filter(|score| is_resolved(score));
    as_likely.next().or(Some(leader))
}

/// The leader, or the smaller form that it contains if it has nothing significant beyond it.
fn simplest<'s>(
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
    // In the order of their 2 ln B.
    smaller.next().or(Some(leader))
}

/// The leader; but of a coupling of axes as an angle only where this shows, since a tilt that is constant through a run is
/// taken for the place of its targets: otherwise the plain one, which explains as much.
fn plain<'s>(
    listed: &Listed,
    beside: &Beside,
    scores: &'s [Score],
    leader: &'s Score,
) -> &'s Score {
    let is_of_angle = |score: &Score| {
        let subject = &listed.candidate(beside, score).hypothesis.subject;
        subject.other_axis.map(|_| subject.component.is_some())
    };
    let variance = beside.model.squares() / beside.model.degrees_of_freedom;
    let enough = leader.statistic - DECISIVE * variance.max(1.0);
    let is_plain = |s: &&Score| is_of_angle(s) == Some(false) && s.statistic >= enough;
    let plain = scores.iter().find(is_plain);
    let plain = plain.filter(|_| is_of_angle(leader) == Some(true));
    plain.unwrap_or(leader)
}

/// Logarithm of the p-value of what a larger form explains beyond a smaller one that it contains.
pub(super) fn ln_more(model: &Projection, smaller: &Score, larger: &Score) -> f64 {
    let more = larger.statistic - smaller.statistic;
    let left = model.squares() - smaller.statistic;
    let freedom = model.degrees_of_freedom - smaller.rank as f64;
    ln_f_test(more, left, larger.rank - smaller.rank, freedom)
}

/// Whether `with`, the model extended by some form, leaves nothing of columns of which `model` leaves something.
pub(crate) fn contains(model: &Projection, with: &Projection, columns: &[Vec<f64>]) -> bool {
    let left = |projection: &Projection, column: &[f64]| squares(&projection.left_of(column));
    let is_contained = |c: &Vec<f64>| left(with, c) <= CONTAINED * left(model, c);
    columns.iter().all(is_contained)
}

/// Most rounds in which several shapes converge.
const MOST_ROUNDS: usize = 12;

/// How many times the change of a round goes on at most, and how exactly that is sought.
const FARTHEST: f64 = 20.0;
const EXACT: f64 = 0.02;

/// Refines several shapes: one at a time creeps where they hide each other, as two time constants do, and goes on along
/// the change of each round (Powell 1964).
fn refine_together(listed: &Listed, causes: &mut [Chosen], continuous: &[usize]) {
    for _ in 0..MOST_ROUNDS {
        let before = causes.to_vec();
        for &k in continuous {
            let model = listed.with(&without(causes, k));
            let candidate = &listed.candidates[causes[k].candidate];
            causes[k].shape = candidate.converged(&model, causes[k].shape);
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
