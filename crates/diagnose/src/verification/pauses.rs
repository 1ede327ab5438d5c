//! How long a machine pauses between two cycles is not in a table without a clock.
//!
//! What drifts goes on meanwhile. By the numbers of its rows a drift is then quicker than within the cycles, where it is slower by
//! what grows on the way there and falls on the way back: lost motion that changes along the axis. So beside a cause of time
//! lost motion is judged once more with an offset for each cycle, which stands for the pause before it.

use crate::Rival;
use crate::engine::{Chosen, FURTHER_LEVEL, Listed};
use crate::verification::base::{cycles, indicators};
use crate::verification::lost_motion::FORMS;
use crate::verification::problem::Problem;
use crate::verification::search::ln_more;
use crate::verification::wanderer::Wanderer;

/// What pauses leave of lost motion: that which is as large everywhere, or nothing, in which case it is what goes with time.
pub(crate) fn rivals_by_pauses(
    problem: &Problem<'_>,
    causes: &[Chosen],
    k: usize,
    evidence: f64,
) -> Vec<Rival> {
    let comparison = problem.comparison;
    let own = problem.listed.hypothesis(&causes[k]);
    let is_lost_motion = FORMS.contains(&own.effect.id) && own.subject.axis == comparison.line();
    let mut all = causes.iter().map(|cause| problem.listed.hypothesis(cause));
    if comparison.timed || !is_lost_motion || !all.any(|one| one.is_of_time()) {
        return Vec::new();
    }
    // Beside the zero of the line the first one has no meaning.
    let offsets = indicators(&cycles(comparison)).into_iter().skip(1);
    let offsets: Vec<Vec<f64>> = offsets.map(|offset| problem.whiten(&offset)).collect();
    let paused = Listed {
        base: problem.listed.base.extended(&offsets),
        candidates: problem.listed.candidates.clone(),
    };
    let level = problem.level.min(FURTHER_LEVEL);
    let Some(judged) = paused.judge(causes, k).filter(|own| own.p_value < level) else {
        let names = Wanderer::Instrument.names(comparison);
        let with_time = |name: Wanderer| Rival::Disturbance {
            whose: name.whose(comparison),
            evidence,
        };
        return names.map(with_time).collect();
    };
    let beside = &judged.beside;
    let ln_level = paused.candidates[causes[k].candidate].ln_level_of_more(level);
    paused.rivals(&judged, |score, _, _| {
        let other = &paused.candidate(beside, score).hypothesis;
        let is_constant = other.effect.id == "backlash" && other.subject.axis == own.subject.axis;
        is_constant && ln_more(&beside.model, score, &judged.score) > ln_level
    })
}
