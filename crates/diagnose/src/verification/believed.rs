//! Which causes are claimed: those that help on unused readings and do not merely imitate what nothing explains.

use trueaxis_selection::Fit;

use crate::engine::linear::Chosen;
use crate::engine::{Omnibus, is_imitation, still_left};
use crate::verification::held_out::gain_of;
use crate::verification::omnibus::omnibus;
use crate::verification::problem::Problem;

/// Drops causes that do not gain on unused readings with a probability of nine in ten, the weakest first.
///
/// The gain of a true cause of strength λ scatters by 2/λ of itself: at λ = 7 a two-sided interval of 95 % would lose
/// 6 % of the true ones, this bound loses 1 %. Whether a gain is *claimed* depends on the interval.
pub(crate) fn with_gain(problem: &Problem<'_>, causes: &mut Vec<Chosen>) {
    while !causes.is_empty() {
        let bounds = (0..causes.len()).map(|k| {
            let gain = gain_of(problem, causes, k);
            // What cannot be held out cannot be refuted.
            (k, gain.map_or(0.0, |gain| gain.upper_bound))
        });
        match bounds.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((k, bound)) if bound >= 1.0 => causes.remove(k),
            _ => return,
        };
    }
}

/// Drops causes whose effect is in families in which structure is left.
pub(crate) fn without_imitations(problem: &Problem<'_>, causes: &mut Vec<Chosen>) {
    let tests = omnibus(problem, &problem.listed.with(causes));
    let squares = |t: &Omnibus| t.drop - t.test.columns as f64;
    let left = still_left(&problem.families, &tests, problem.level, squares);
    let listed = &problem.listed;
    causes.retain(|cause| {
        let fit = Fit::new(&listed.base, &listed.columns_of(cause));
        let is_of_any_form = listed.candidates[cause.candidate].is_of_any_form();
        !is_imitation(&listed.base, &fit, is_of_any_form, &left)
    });
}
