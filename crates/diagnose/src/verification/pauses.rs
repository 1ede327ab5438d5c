//! A table without a clock does not say how long the machine pauses between two cycles.
//!
//! A drift goes on meanwhile. By row numbers it is then quicker between cycles than within them, where it is slower
//! by what grows on the way there and falls on the way back: lost motion that changes along the axis. Pauses have two
//! extremes, none and all of the time: the drift as the rows show it, or an offset of each cycle instead. If lost
//! motion differs in sign between them, some pauses leave none; the distance is in its uncertainty, and in that of
//! the drift, which over five cycles is a fifth smaller where all of it passes in pauses of one length. Of two cycles
//! the second extreme is a jump between them, which a clock does not exclude.

use trueaxis_effects::{BACKLASH, Level, POSITION_DEPENDENT_BACKLASH, Shape};
use trueaxis_selection::{Fit, Hypothesis, Score};

use crate::Rival;
use crate::engine::disturbance::{Wanderer, Who, With};
use crate::engine::linear::{Chosen, Listed};
use crate::engine::{JudgedDisturbance, without};
use crate::verification::base::{count, cycles, indicators, runs_of_cycles};
use crate::verification::lost_motion;
use crate::verification::paused::farthest_by_pauses;
use crate::verification::problem::Problem;
use crate::verification::wanderer::with_time;

/// Consequences of unknown pauses for lost motion beside a cause in time, and for this.
pub(crate) struct ByPauses {
    /// The constant lost motion; or if none is needed, the disturbance in time.
    pub(crate) rivals: Vec<Rival>,
    /// Distance of the other extreme from the values that are stated.
    pub(crate) shift: Vec<f64>,
}

/// What pauses leave of cause `k` with its fit to observations of this variance: of what goes with the progress of
/// time or warms up, or of lost motion beside causes in time or disturbances; `None` where pauses do not matter.
pub(crate) fn by_pauses(
    problem: &Problem<'_>,
    (causes, wandering): (&[Chosen], &[JudgedDisturbance]),
    (k, fit): (usize, &Fit),
    (two_ln_b, variance): (f64, f64),
) -> Option<ByPauses> {
    let (comparison, listed) = (problem.comparison, &problem.listed);
    let own = listed.hypothesis(&causes[k]);
    if !comparison.timed && own.effect.shape == Shape::TimeConstant {
        return Some(ByPauses {
            rivals: Vec::new(),
            shift: farthest_by_pauses(problem, causes, (k, fit), variance),
        });
    }
    if !comparison.timed && goes_with_progress(own) {
        return in_pauses(problem, causes, (k, fit), variance);
    }
    let is_lost_motion = lost_motion::is_of_line(comparison, own);
    let is_of_time = |cause: &Chosen| listed.hypothesis(cause).is_of_time();
    let mut all = wandering.iter();
    let wanders = all.any(|own| own.wanderer().with == With::Campaign);
    let goes_on = wanders || causes.iter().any(is_of_time);
    if !is_lost_motion || !goes_on {
        return None;
    }
    // Mean and slope; for a constant the mean alone. What else a free form has is rougher than any pause makes.
    let straight = match own.effect == POSITION_DEPENDENT_BACKLASH {
        true => 2,
        false => 1,
    };
    let is_free = fit.estimates.len() > straight;
    let cycles = cycles(comparison);
    // Of two cycles a clock does not tell a drift from a jump between them, either.
    if count(&cycles) < 2 || comparison.timed && count(&cycles) > 2 {
        return None;
    }
    let paused = listed.on(listed.base.extended(&offsets(problem, &cycles, wandering)));
    let without_time = causes.iter().filter(|cause| !is_of_time(cause));
    let without_time: Vec<Chosen> = without_time.copied().collect();
    let sized = |among: &[Chosen], place: usize| paused.sizes(among).swap_remove(place).fit;
    let number = without_time.iter().position(|cause| *cause == causes[k])?;
    let all_in_pauses = sized(&without_time, number);
    // Beside the slope nothing shows what drifts within the cycles; beside a constant it may be seen.
    let as_seen = (straight == 1).then(|| sized(causes, k));
    let shift = |i: usize| towards(&all_in_pauses, as_seen.as_ref(), (fit, i), variance);
    let vanishes = |i: usize| {
        let (value, other) = (fit.estimates[i], fit.estimates[i] + shift(i));
        all_in_pauses.seen[i]
            && (value * other <= 0.0 || other.abs() < COVERAGE * u(&all_in_pauses, i, variance))
    };
    let vanishing = [0, 1].map(|i| !is_free && (i >= straight || vanishes(i)));
    let rivals = match vanishing {
        [true, true] => {
            let rival = |name| Rival::of(Level::Verification, name, two_ln_b);
            with_time(comparison).map(rival).collect()
        }
        [false, true] if own.effect == POSITION_DEPENDENT_BACKLASH => {
            Vec::from_iter(constant(&paused, &without_time, number))
        }
        _ => Vec::new(),
    };
    Some(ByPauses {
        rivals,
        shift: (0..fit.estimates.len())
            .map(|i| if i < straight { shift(i) } else { 0.0 })
            .collect(),
    })
}

/// Whether a cause grows with the progress of time, and has no time of its own.
fn goes_with_progress(own: &Hypothesis) -> bool {
    own.effect.shape == Shape::Fixed && (own.is_of_time() || own.effect.grows_axis())
}

/// The same where time passes in pauses of one length between the cycles: all of it, and with a part of its own within
/// them that the readings show. `None` without a pause.
fn in_pauses(
    problem: &Problem<'_>,
    causes: &[Chosen],
    (k, fit): (usize, &Fit),
    variance: f64,
) -> Option<ByPauses> {
    let listed = &problem.listed;
    let mut paused = problem.comparison.clone();
    let cycles = runs_of_cycles(&paused);
    let last = count(&cycles).checked_sub(1).filter(|last| *last > 0)?;
    for (arrival, cycle) in paused.arrivals.iter_mut().zip(cycles) {
        arrival.progress = cycle as f64 / last as f64;
    }
    let of_pauses = |cause: &Chosen| -> Vec<Vec<f64>> {
        let own = listed.hypothesis(cause);
        let column = |i| problem.whiten(&paused.column(own, i, cause.shape));
        match goes_with_progress(own) {
            true => (0..listed.candidates[cause.candidate].plausible.len())
                .map(column)
                .collect(),
            false => listed.columns_of(cause),
        }
    };
    let own = of_pauses(&causes[k]);
    let others = without(causes, k);
    let beside: Vec<Vec<f64>> = others.iter().flat_map(of_pauses).collect();
    let all_in_pauses = Fit::new(&listed.base.extended(&beside), &own);
    // With a part of it in the pauses; all of it is the first value.
    let over_rows = listed.columns_of(&causes[k]);
    let less_rows = |(own, over_rows): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
        own.iter().zip(over_rows).map(|(a, b)| a - b).collect()
    };
    let more: Vec<Vec<f64>> = own.iter().zip(&over_rows).map(less_rows).collect();
    let as_seen = Fit::new(&listed.with(&others), &[over_rows, more].concat());
    let shift = |i: usize| towards(&all_in_pauses, Some(&as_seen), (fit, i), variance);
    Some(ByPauses {
        rivals: Vec::new(),
        shift: (0..fit.estimates.len()).map(shift).collect(),
    })
}

/// Distance of the other extreme from value `i`, no further than the readings show it if they do.
fn towards(
    all_in_pauses: &Fit,
    as_seen: Option<&Fit>,
    (fit, i): (&Fit, usize),
    variance: f64,
) -> f64 {
    if !all_in_pauses.seen[i] {
        return 0.0;
    }
    let most = all_in_pauses.estimates[i] - fit.estimates[i];
    let bound = match as_seen.filter(|seen| seen.seen[i]) {
        Some(seen) => {
            (seen.estimates[i] - fit.estimates[i]).abs() + COVERAGE * u(seen, i, variance)
        }
        None => f64::INFINITY,
    };
    most.signum() * most.abs().min(bound)
}

/// Standard uncertainty of a value from observations of this variance.
fn u(fit: &Fit, i: usize, variance: f64) -> f64 {
    let place = i * fit.estimates.len() + i;
    (fit.covariance[place].max(0.0) * variance).sqrt()
}

/// A whitened offset of each cycle but the first, which has that of the line; where the scale wanders a slope, too.
fn offsets(
    problem: &Problem<'_>,
    cycles: &[usize],
    wandering: &[JudgedDisturbance],
) -> Vec<Vec<f64>> {
    let comparison = problem.comparison;
    let mut offsets: Vec<Vec<f64>> = indicators(cycles).into_iter().skip(1).collect();
    let is_scale = |own: Wanderer| own.with == With::Campaign && matches!(own.who, Who::Axis(_));
    if wandering.iter().any(|own| is_scale(own.wanderer())) {
        let slope = |offset: &Vec<f64>| -> Vec<f64> {
            let arrivals = comparison.arrivals.iter().zip(offset);
            arrivals
                .map(|(a, x)| x * (comparison.travelled(a) - 0.5))
                .collect()
        };
        let slopes: Vec<Vec<f64>> = offsets.iter().map(slope).collect();
        offsets.extend(slopes);
    }
    let whitened = offsets.iter().map(|offset| problem.whiten(offset));
    whitened.collect()
}

impl ByPauses {
    /// Adds to a covariance, in units of the variance, that all values up to the other extreme are equally likely:
    /// the mean square from the stated one is a third of that distance squared.
    pub(crate) fn add_to(&self, covariance: &mut [f64], variance: f64) {
        let n = self.shift.len();
        for (i, a) in self.shift.iter().enumerate() {
            for (j, b) in self.shift.iter().enumerate() {
                covariance[i * n + j] += a * b / (3.0 * variance);
            }
        }
    }
}

/// A value within this many standard uncertainties of zero may be zero.
const COVERAGE: f64 = 2.0;

/// The constant form of a lost motion that changes along the axis.
fn constant(listed: &Listed, causes: &[Chosen], k: usize) -> Option<Rival> {
    let own = listed.hypothesis(&causes[k]);
    let beside = listed.beside(&without(causes, k));
    let is_it = |score: &&Score| {
        let other = &listed.candidate(&beside, score).hypothesis;
        other.effect == BACKLASH && other.subject == own.subject
    };
    let score = beside.scores.iter().find(is_it)?;
    let columns = listed.candidate(&beside, score).columns(score.shape);
    Some(listed.rival(&beside, score, &Fit::new(&beside.model, &columns)))
}
