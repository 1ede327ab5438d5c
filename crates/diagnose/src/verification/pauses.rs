//! How long a machine pauses between two cycles is not in a table without a clock.
//!
//! What drifts goes on meanwhile. By the numbers of its rows a drift is then quicker than within the cycles, where it is slower by
//! what grows on the way there and falls on the way back: lost motion that changes along the axis. Pauses are not shorter than nothing
//! and not longer than all: beside the drift as the rows tell it, and beside an offset of each cycle instead of it, lost motion has its
//! two extremes. If they differ in sign, there are pauses with which there is none.

use crate::Rival;
use crate::engine::{Chosen, Listed};
use crate::selection::Fit;
use crate::verification::base::{count, cycles, indicators};
use crate::verification::lost_motion::{EFFECT, FORMS};
use crate::verification::problem::Problem;
use crate::verification::wanderer::Wanderer;

/// What pauses leave of lost motion, cause `k` with its fit, beside a cause of time: that which is as large everywhere, or nothing, in which case it is what
/// goes with time.
pub(crate) fn rivals_by_pauses(
    problem: &Problem<'_>,
    causes: &[Chosen],
    (k, fit): (usize, &Fit),
    evidence: f64,
) -> Vec<Rival> {
    let (comparison, listed) = (problem.comparison, &problem.listed);
    let own = listed.hypothesis(&causes[k]);
    let is_lost_motion = FORMS.contains(&own.effect.id) && own.subject.axis == comparison.line();
    let is_of_time = |cause: &Chosen| listed.hypothesis(cause).is_of_time();
    if comparison.timed || !is_lost_motion || !causes.iter().any(is_of_time) {
        return Vec::new();
    }
    // Mean and slope, of a constant the mean alone. Half waves are rougher than any pause makes.
    let straight = match own.effect.id == EFFECT {
        true => 2,
        false => 1,
    };
    let cycles = cycles(comparison);
    if count(&cycles) < 2 || fit.estimates.len() != straight {
        return Vec::new();
    }
    // Beside the zero of the line the first one has no meaning.
    let offsets = indicators(&cycles).into_iter().skip(1);
    let offsets: Vec<Vec<f64>> = offsets.map(|offset| problem.whiten(&offset)).collect();
    let paused = Listed {
        base: listed.base.extended(&offsets),
        candidates: listed.candidates.clone(),
    };
    let mut others: Vec<Chosen> = causes.to_vec();
    others.retain(|cause| !is_of_time(cause));
    let Some(number) = others.iter().position(|cause| *cause == causes[k]) else {
        return Vec::new();
    };
    let with_pauses = &paused.sizes(&others)[number].fit;
    let turns =
        |i: usize| with_pauses.seen[i] && fit.estimates[i] * with_pauses.estimates[i] <= 0.0;
    let turning = [0, 1].map(|i| i >= straight || turns(i));
    match turning {
        [true, true] => {
            let names = Wanderer::Instrument.names(comparison);
            let with_time = |name: Wanderer| Rival::Disturbance {
                whose: name.whose(comparison),
                evidence,
            };
            names.map(with_time).collect()
        }
        [false, true] if own.effect.id == EFFECT => constant(&paused, &others, number),
        _ => Vec::new(),
    }
}

/// The constant form of a lost motion that changes along the axis.
fn constant(listed: &Listed, causes: &[Chosen], k: usize) -> Vec<Rival> {
    let Some(judged) = listed.judge(causes, k) else {
        return Vec::new();
    };
    let own = listed.hypothesis(&causes[k]);
    listed.rivals(&judged, |score, _, _| {
        let other = &listed.candidate(&judged.beside, score).hypothesis;
        let is_form = FORMS.contains(&other.effect.id) && other.subject == own.subject;
        is_form && other.effect.id != EFFECT
    })
}
