//! What several series of readings have in common is one cause with one size.
//!
//! Each series was judged by itself. Over all of them together ([`Stack`])
//!
//! 1. every cause of the machine that a series named is tried with one size for all, and is replaced by one that has
//!    a larger 2 ln B there: a second line at another feed separates lost motion from an offset of the time stamps;
//! 2. what no series shows alone, but all together do, joins; what has become superfluous leaves ([`search`]);
//! 3. a cause whose sizes differ between the series by more than chance (F test of a size for each series) and by
//!    more than a tenth stays with the series that named it, each with its own. Where they scatter less, this is
//!    within the uncertainty of the common size.
//!
//! A cause that no series named must also gain on unused readings and not imitate what is left in any.

use trueaxis_predict::CalibratedMachine;
use trueaxis_selection::{Hypothesis, f_test};

use crate::Cause;
use crate::cause::SIZES_DIFFER;
use crate::engine::linear::{Among, Candidate, Chosen, Listed, MOST_CAUSES, contains};
use crate::engine::without;
use crate::numbers::whole;
use crate::verification::believed::without_imitations;
use crate::verification::joined::joint_cause;
use crate::verification::model::has;
use crate::verification::series::Series;
use crate::verification::stack::{Stack, is_of_all};
use crate::verification::take_away::takes_own_away;

/// A cause that two or more series show.
pub(crate) struct Shared {
    /// Its index among the hypotheses of each series that shows it.
    pub(crate) candidates: Vec<Option<usize>>,
    /// With the common size.
    pub(crate) cause: Cause,
}

/// Share of what a common size explains that separate sizes may add: they scatter by a tenth about their mean.
const ONE_SIZE: f64 = 0.01;

/// Gives each series its causes in view of all, and returns those common to several.
pub(crate) fn together(
    all: &mut [Series<'_>],
    calibration: Option<&CalibratedMachine>,
) -> Vec<Shared> {
    if all.len() < 2 {
        return Vec::new();
    }
    let level = all[0].plain.level;
    let mut apart: Vec<Hypothesis> = Vec::new();
    let (found, causes, judged) = loop {
        let (stack, own) = stacked(all, &apart, calibration);
        let named = stack.named();
        let all_named = Among {
            // As likely as that one of the series had named it.
            further: level * all.len() as f64,
            ..Among::all(&stack.listed, level * all.len() as f64)
        };
        let found = all_named.revised(named.clone());
        let search = Among {
            most: found.len() + MOST_CAUSES,
            ..Among::all(&stack.listed, level)
        };
        let found = search.after(found);
        let of_each = stack.of_each(&own, &found);
        let sizes = (0..found.len()).map(|k| Sizes::new(&stack, &found, k));
        let sizes: Vec<Sizes> = sizes.collect();
        let doubtful = (0..found.len()).find(|&k| {
            sizes[k].are_several()
                || takes_own_away(&stack, &own, &found, k)
                || !has(&named, &found[k]) && !is_believed(&stack, &of_each, &found, k)
        });
        let Some(k) = doubtful else {
            break (found, of_each, sizes);
        };
        // The cause that it replaced goes back to its series.
        let is_replaced = |n: &&Chosen| !has(&named, &found[k]) && !has(&found, n);
        let replaced = named.iter().filter(is_replaced);
        let back = replaced.chain([&found[k]]);
        apart.extend(back.map(|cause| *stack.listed.hypothesis(cause)));
        apart.extend(other_forms(&stack.listed, &found[k]));
    };
    for (series, causes) in all.iter_mut().zip(&causes) {
        series.set_causes(causes.clone());
    }
    // With the disturbances beside these causes; whether sizes scatter is known from the shapes of the series.
    let (stack, _) = stacked(all, &apart, calibration);
    let shared = (0..found.len()).filter_map(|k| {
        let members = stack.members[found[k].candidate].iter().zip(&causes);
        let shown = members.map(|(member, causes)| {
            member.filter(|number| causes.iter().any(|c| c.candidate == *number))
        });
        let candidates: Vec<Option<usize>> = shown.collect();
        if candidates.iter().flatten().count() < 2 {
            return None;
        }
        let of_all = Sizes::new(&stack, &found, k).variances;
        let variance = of_all[usize::from(judged[k].differ())];
        let members = (0..all.len()).filter(|&number| candidates[number].is_some());
        let cause = joint_cause(&stack, (&found, k), members, variance)?;
        let gain = stack.gain_of(&found[k], &causes);
        let cause = Cause {
            heldout_gain: gain.map(|gain| 1.0 - gain.ratio.ratio),
            sizes_p_value: Some(judged[k].p_value),
            ..cause
        };
        Some(Shared { candidates, cause })
    });
    shared.collect()
}

/// The system of what may be common, except hypotheses that stay `apart`, and the causes that series do not share.
fn stacked<'s>(
    all: &'s [Series<'s>],
    apart: &[Hypothesis],
    calibration: Option<&CalibratedMachine>,
) -> (Stack<'s>, Vec<Vec<Chosen>>) {
    let is_joint = |hypothesis: &Hypothesis| !apart.iter().any(|other| other.is(hypothesis));
    let own: Vec<Vec<Chosen>> = all.iter().map(|s| its_own(s, is_joint)).collect();
    (Stack::new(all, &own, is_joint, calibration), own)
}

/// The causes of a series that it does not share with others.
fn its_own(series: &Series<'_>, is_joint: impl Fn(&Hypothesis) -> bool) -> Vec<Chosen> {
    let candidates = &series.plain.listed.candidates;
    let causes = series.model.causes.iter();
    let is_own = |cause: &&Chosen| {
        let candidate = &candidates[cause.candidate];
        !(is_of_all(series, candidate) && is_joint(&candidate.hypothesis))
    };
    causes.filter(is_own).copied().collect()
}

/// The forms that contain a cause or are contained in it: where it has several sizes, so have they. Otherwise a line whose
/// lost motion changes along the axis can be given the constant one of another line, where it was right by itself.
fn other_forms(listed: &Listed, cause: &Chosen) -> Vec<Hypothesis> {
    let with = |columns: &[Vec<f64>]| listed.base.extended(columns);
    let own = listed.columns_of(cause);
    let with_own = with(&own);
    let is_form = |candidate: &&Candidate<'_>| {
        candidate.columns.shapes().len() == 1 && {
            let columns = &candidate.columns.whole(0);
            contains(&listed.base, &with_own, columns)
                || contains(&listed.base, &with(columns), &own)
        }
    };
    let forms = listed.candidates.iter().filter(is_form);
    forms.map(|candidate| candidate.hypothesis).collect()
}

/// The sizes of a cause in the series about the common one.
struct Sizes {
    /// Probability that chance alone scatters them as much (F test of a size for each series).
    p_value: f64,
    /// What separate sizes explain beyond the common one, as a share of what that explains.
    more: f64,
    /// Variances: of what the common size leaves, and of the scatter of the sizes or of the noise beside them.
    variances: [f64; 2],
}

impl Sizes {
    fn new(stack: &Stack<'_>, causes: &[Chosen], k: usize) -> Self {
        let others = stack.listed.with(&without(causes, k));
        let common = others.extended(&stack.listed.columns_of(&causes[k]));
        let apart = others.extended(&stack.apart(&causes[k]));
        let rank = (common.degrees_of_freedom - apart.degrees_of_freedom).max(0.0)
            + stack.more_shapes(&causes[k]) as f64;
        let drop = common.squares() - apart.squares();
        let variance = apart.squares() / apart.degrees_of_freedom.max(1.0);
        Self {
            p_value: f_test(
                drop,
                common.squares(),
                whole(rank),
                common.degrees_of_freedom,
            ),
            more: drop / (others.squares() - common.squares()),
            variances: [
                common.squares() / common.degrees_of_freedom.max(1.0),
                (drop / rank.max(1.0)).max(variance),
            ],
        }
    }

    /// Whether they scatter by more than chance: then the uncertainty of the common size is that of this scatter (R.
    /// T. Birge, 1932).
    fn differ(&self) -> bool {
        self.p_value < SIZES_DIFFER
    }

    /// Whether they are different sizes.
    fn are_several(&self) -> bool {
        self.differ() && self.more >= ONE_SIZE
    }
}

/// Whether two series can show a cause, it gains on unused readings of all series with a probability of nine in ten,
/// and in none that shows it by itself it imitates what is left.
fn is_believed(stack: &Stack<'_>, of_each: &[Vec<Chosen>], causes: &[Chosen], k: usize) -> bool {
    let cause = &causes[k];
    let members = stack.members[cause.candidate].iter();
    if members.flatten().count() < 2 {
        return false;
    }
    let explained = stack.explained(causes, k);
    let imitates = |number: usize| {
        if explained[number] <= stack.of_noise(cause) {
            return false;
        }
        let series = &stack.all[number];
        let mut kept = of_each[number].clone();
        without_imitations(&series.model.problem, &mut kept);
        let is_it = |c: &Chosen| Some(c.candidate) == stack.members[cause.candidate][number];
        of_each[number].iter().any(is_it) && !kept.iter().any(is_it)
    };
    let gain = || stack.gain_of(cause, of_each);
    !(0..explained.len()).any(imitates) && gain().is_none_or(|gain| gain.upper_bound < 1.0)
}
