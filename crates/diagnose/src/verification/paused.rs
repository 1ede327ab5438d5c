//! Readings without a clock, as if the machine had paused after each cycle.
//!
//! What warms up goes on in pauses: by row numbers it is steeper between the cycles than within them, and no time
//! constant follows both. So the length of the pauses is one more unknown: for some lengths the time constants are
//! sought again, and the values that likely lengths give are in the uncertainty.

use trueaxis_effects::Shape;
use trueaxis_selection::Fit;

use crate::engine::linear::{Chosen, Listed};
use crate::engine::without;
use crate::verification::base::{count, runs_of_cycles};
use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::candidates;
use crate::verification::problem::Problem;

/// Pauses that are tried, in durations of a cycle.
const LENGTHS: [f64; 6] = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2];

/// Pauses are likely within two standard deviations of the likeliest, in `-2 ln L`.
const LIKELY: f64 = 4.0;

/// Distance of the farthest values that likely pauses give cause `k`, which warms up, from those that are stated;
/// nothing where there is one cycle.
pub(crate) fn farthest_by_pauses(
    problem: &Problem<'_>,
    causes: &[Chosen],
    (k, fit): (usize, &Fit),
    variance: f64,
) -> Vec<f64> {
    let (comparison, listed) = (problem.comparison, &problem.listed);
    let cycles = runs_of_cycles(comparison);
    let mut values = vec![(listed.with(causes).squares(), fit.estimates.clone())];
    if count(&cycles) > 1 {
        values.extend(LENGTHS.iter().filter_map(|&length| {
            let paused = paused(comparison, &cycles, length);
            let candidates = candidates(&paused, problem.scene, problem.whitening);
            let listed = Listed::new(listed.base.clone(), candidates.into());
            let all = converged(&listed, causes.to_vec())?;
            let others = listed.with(&without(&all, k));
            let fit = Fit::new(&others, &listed.columns_of(&all[k]));
            Some((listed.with(&all).squares(), fit.estimates))
        }));
    }
    let least = values.iter().map(|own| own.0).fold(f64::INFINITY, f64::min);
    values.retain(|(squares, _)| squares - least < LIKELY * variance);
    let farthest = |(i, stated): (usize, &f64)| {
        let from = values.iter().map(|(_, values)| values[i] - stated);
        from.max_by(|a, b| a.abs().total_cmp(&b.abs()))
            .unwrap_or(0.0)
    };
    fit.estimates.iter().enumerate().map(farthest).collect()
}

/// A comparison with pauses of this many durations of a cycle after each of its cycles.
fn paused<'a>(comparison: &Comparison<'a>, cycles: &[usize], length: f64) -> Comparison<'a> {
    let mut paused = comparison.clone();
    let last_s = |of: &Comparison<'_>| of.arrivals.iter().map(|a| a.elapsed_s).fold(0.0, f64::max);
    let pause_s = length * last_s(comparison) / count(cycles) as f64;
    for (arrival, &cycle) in paused.arrivals.iter_mut().zip(cycles) {
        arrival.elapsed_s += pause_s * cycle as f64;
    }
    let duration_s = last_s(&paused).max(f64::MIN_POSITIVE);
    for arrival in &mut paused.arrivals {
        arrival.progress = arrival.elapsed_s / duration_s;
    }
    paused
}

/// Causes with their time constants sought again; `None` if one of them is not seen any more.
fn converged(listed: &Listed<'_>, mut causes: Vec<Chosen>) -> Option<Vec<Chosen>> {
    for k in 0..causes.len() {
        if listed.hypothesis(&causes[k]).effect.shape == Shape::TimeConstant {
            let beside = listed.beside(&without(&causes, k));
            let score = beside.score_of(&causes[k])?;
            causes[k] = listed.chosen(&beside, &score);
        }
    }
    Some(causes)
}
