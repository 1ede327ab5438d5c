//! What several series of readings have in common is one cause with one size.
//!
//! Each series was judged by itself. Over all of them together ([`Stack`])
//!
//! 1. every cause of the machine that a series named is tried with one size for all, and gives its place to one that has
//!    more evidence there: a second line at another feed tells lost motion from an offset of the time stamps;
//! 2. what no series shows alone, but all together do, joins; what has become superfluous leaves ([`search_beside`]);
//! 3. a cause whose sizes differ between the series by more than chance (F test of a size for each series) and by more than
//!    a tenth stays with the series that named it, each with its own. Where they scatter by less, the uncertainty of the
//!    common size contains that.
//!
//! A cause that no series named must also gain on unused readings and not imitate what is left in any.

use trueaxis_calibrate::CalibratedMachine;
use trueaxis_effects::Scene;

use crate::Cause;
use crate::engine::{Candidate, Chosen, Listed, without};
use crate::selection::{Hypothesis, f_test};
use crate::verification::competition::without_imitations;
use crate::verification::held_out::{blocks_of, gain_of_blocks};
use crate::verification::joined::joint_cause;
use crate::verification::search::{contains, drop_superfluous, search_beside, simplest};
use crate::verification::series::Series;
use crate::verification::stack::{Stack, is_of_all};

/// A cause that two series or more show.
pub(crate) struct Shared {
    /// Its number among the hypotheses of each series that shows it.
    pub(crate) candidates: Vec<Option<usize>>,
    /// With the size that they have in common.
    pub(crate) cause: Cause,
}

/// Probability of sizes that scatter as much, above which it is chance.
const BY_CHANCE: f64 = 0.01;

/// Part of what a common size explains that sizes of their own may explain beyond it: they scatter by a tenth about their mean.
const ONE_SIZE: f64 = 0.01;

/// Gives each series the causes that it has in the light of all, and says which of them are common to several.
pub(crate) fn together(
    all: &mut [Series<'_>],
    calibration: Option<&CalibratedMachine>,
    scene: &Scene,
) -> Vec<Shared> {
    if all.len() < 2 {
        return Vec::new();
    }
    let mut apart: Vec<Hypothesis> = Vec::new();
    let (causes, shared) = loop {
        let is_joint = |hypothesis: &Hypothesis| !apart.iter().any(|other| other.is(hypothesis));
        let own: Vec<Vec<Chosen>> = all.iter().map(|s| its_own(s, is_joint)).collect();
        let stack = Stack::new(all, &own, is_joint, calibration);
        let named = stack.named();
        let level = all[0].level;
        let mut found = exchanged(&stack.listed, named.clone(), level);
        if found.len() > 1 {
            // As likely as that one of the series had named it.
            drop_superfluous(&stack.listed, &mut found, level * all.len() as f64);
            // Of two forms of one effect the smaller may be the one that is left out.
            found = exchanged(&stack.listed, found, level);
        }
        found = search_beside(&stack.listed, found, &[], level);
        let of_each = stack.of_each(&own, &found);
        let is_known = |cause: &Chosen| named.iter().any(|n| n.candidate == cause.candidate);
        let scatters: Vec<Option<f64>> = (0..found.len())
            .map(|k| scatter(&stack, &found, k))
            .collect();
        let doubtful = (0..found.len()).find(|&k| {
            scatters[k].is_none()
                || !is_known(&found[k])
                    && !is_believed(all, &of_each, &stack.members[found[k].candidate])
        });
        if let Some(k) = doubtful {
            // What it took the place of goes back to its series.
            let is_found = |n: &Chosen| found.iter().any(|f| f.candidate == n.candidate);
            let replaced = named
                .iter()
                .filter(|n| !is_known(&found[k]) && !is_found(n));
            let back = replaced.chain([&found[k]]);
            apart.extend(back.map(|cause| *stack.listed.hypothesis(cause)));
            apart.extend(other_forms(&stack.listed, &found[k]));
            continue;
        }
        let shared = (0..found.len()).filter_map(|k| {
            let members = stack.members[found[k].candidate].iter().zip(&of_each);
            let shown = members.map(|(member, causes)| {
                member.filter(|number| causes.iter().any(|c| c.candidate == *number))
            });
            let candidates: Vec<Option<usize>> = shown.collect();
            (candidates.iter().flatten().count() > 1).then(|| {
                let cause = joint_cause(&stack.listed, scene, &found, k, scatters[k]?)?;
                Some(Shared { candidates, cause })
            })?
        });
        let shared = shared.collect();
        break (of_each, shared);
    };
    for (series, causes) in all.iter_mut().zip(causes) {
        series.set_causes(causes);
    }
    shared
}

/// The causes of a series that it does not have in common with others.
fn its_own(series: &Series<'_>, is_joint: impl Fn(&Hypothesis) -> bool) -> Vec<Chosen> {
    let candidates = &series.plain.listed.candidates;
    let causes = series.model.causes.iter();
    let is_own = |cause: &&Chosen| {
        let candidate = &candidates[cause.candidate];
        !(is_of_all(candidate) && is_joint(&candidate.hypothesis))
    };
    causes.filter(is_own).copied().collect()
}

/// Causes that give their places to others with more evidence, at most.
const MOST_EXCHANGES: usize = 8;

/// The causes with the best shapes over all series; each gives its place to what has more evidence.
fn exchanged(listed: &Listed, mut causes: Vec<Chosen>, level: f64) -> Vec<Chosen> {
    for _ in 0..MOST_EXCHANGES {
        let before = causes.clone();
        for k in 0..causes.len() {
            let Some(judged) = listed.judge(&causes, k) else {
                continue;
            };
            let scores = &judged.beside.scores;
            if let Some(leader) = simplest(listed, &judged.beside, scores, level) {
                causes[k] = judged.beside.chosen(leader);
            }
        }
        if causes == before {
            break;
        }
    }
    causes
}

/// The forms that hold a cause or are held by it: where its size is not one, theirs is none either.
fn other_forms(listed: &Listed, cause: &Chosen) -> Vec<Hypothesis> {
    let with = |columns: &[Vec<f64>]| listed.base.extended(columns);
    let own = listed.columns(std::slice::from_ref(cause));
    let with_own = with(&own);
    let is_form = |candidate: &&Candidate| {
        candidate.shapes.len() == 1 && {
            let columns = &candidate.columns[0];
            contains(&listed.base, &with_own, columns)
                || contains(&listed.base, &with(columns), &own)
        }
    };
    let forms = listed.candidates.iter().filter(is_form);
    forms.map(|candidate| candidate.hypothesis).collect()
}

/// The variance of the observations that the uncertainty of the common size follows from: what is left, or where the sizes of
/// the series scatter by more than that, what this scatter is (R. T. Birge, 1932); none if they are different sizes.
fn scatter(stack: &Stack<'_>, causes: &[Chosen], k: usize) -> Option<f64> {
    let others = stack.listed.with(&without(causes, k));
    let common = others.extended(&stack.listed.columns(&causes[k..=k]));
    let apart = others.extended(&stack.apart(&causes[k]).concat());
    let more = common.degrees_of_freedom - apart.degrees_of_freedom;
    let drop = common.squares() - apart.squares();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count"
    )]
    let rank = more.max(0.0) as usize;
    if f_test(drop, common.squares(), rank, common.degrees_of_freedom) > BY_CHANCE {
        return Some(common.squares() / common.degrees_of_freedom.max(1.0));
    }
    let is_one = drop < ONE_SIZE * (others.squares() - common.squares());
    let variance = apart.squares() / apart.degrees_of_freedom.max(1.0);
    is_one.then(|| (drop / more).max(variance))
}

/// Whether a cause gains on readings of all series that were not used, with a probability of nine in ten, and imitates in
/// none what is left.
fn is_believed(all: &[Series<'_>], causes: &[Vec<Chosen>], members: &[Option<usize>]) -> bool {
    let mut blocks = Vec::new();
    let mut is_imitation = false;
    for ((series, causes), member) in all.iter().zip(causes).zip(members) {
        let Some(k) = causes.iter().position(|c| Some(c.candidate) == *member) else {
            continue;
        };
        let problem = &series.model.problem;
        let mut kept = causes.clone();
        without_imitations(problem, &mut kept, &series.look());
        is_imitation |= !kept.contains(&causes[k]);
        blocks.extend(blocks_of(problem, causes, k, &series.folds));
    }
    !is_imitation && gain_of_blocks(&blocks).is_none_or(|gain| gain.upper_bound < 1.0)
}
