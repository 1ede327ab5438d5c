//! Tables that name one side of approach although their axis went there and back.
//!
//! On the way back each position is read again, the one where the axis turned at once, the first one last. What
//! drifts in between grows with that time (straight or curved: time and its square are in the model); lost motion is
//! there from the first. Where it stands out from both, the way back came from the other side. At a single position
//! readings that are higher and lower in turn came from either side in turn.

use std::collections::BTreeMap;

use trueaxis_selection::{Fit, Projection};

use crate::numbers::{extremes, mean};
use crate::verification::arrivals::is_same;
use crate::verification::base::{count as count_of, stands};
use crate::verification::comparison::Comparison;

/// Fewest positions read twice in a cycle, and least share of all.
const LEAST_PAIRS: usize = 12;
const MOST_OF_ALL: f64 = 2.0 / 3.0;

/// On the way back the shortest time between the two is at most this share of the longest.
const THERE_AND_BACK: f64 = 1.0 / 3.0;

/// First visits of a single position that do not count, taken too early, and fewest others.
const SETTLING: usize = 2;
const LEAST_VISITS: usize = 12;

/// Probability of a doubt where there is no lost motion.
const LEVEL: f64 = 1e-4;

/// Least difference in standard deviations of a single one: any smaller one may be noise that is not white.
const PLAINLY: f64 = 3.0;

/// A notice about a line whose rows name one side.
pub(crate) fn doubt(comparison: &Comparison<'_>) -> Option<String> {
    comparison.line()?;
    let arrivals = &comparison.arrivals;
    let direction = arrivals.first()?.direction;
    if arrivals.iter().any(|a| !is_same(a.direction, direction)) {
        return None;
    }
    let stands = stands(comparison);
    if count_of(&stands) == 1 {
        return in_turn(comparison, direction);
    }
    let mut visits: BTreeMap<(u32, usize), Vec<usize>> = BTreeMap::new();
    for (number, (arrival, stand)) in arrivals.iter().zip(stands).enumerate() {
        let visit = (arrival.cycle, stand);
        visits.entry(visit).or_default().push(number);
    }
    let pairs = || {
        visits
            .values()
            .filter_map(|own| <[usize; 2]>::try_from(&own[..]).ok())
    };
    let of_pairs = |f: &dyn Fn([usize; 2]) -> f64| pairs().map(f).collect::<Vec<f64>>();
    let count = pairs().count();
    let later_s = of_pairs(&|[a, b]| arrivals[b].elapsed_s - arrivals[a].elapsed_s);
    let [shortest_s, longest_s] = extremes(later_s.iter().copied());
    if count < LEAST_PAIRS
        || (count as f64) < MOST_OF_ALL * visits.len() as f64
        || shortest_s > THERE_AND_BACK * longest_s
    {
        return None;
    }
    let higher_um = of_pairs(&|[a, b]| arrivals[b].value_um - arrivals[a].value_um);
    let mean_um = mean(&higher_um);
    let squares = later_s.iter().map(|later_s| later_s * later_s).collect();
    let drift = Projection::dense(higher_um, &[later_s, squares]);
    let fit = Fit::new(&drift, &[vec![1.0; count]]);
    let left = (drift.squares() - fit.gained()).max(0.0);
    let sd_um = (left / (drift.degrees_of_freedom - 1.0)).sqrt();
    (fit.ln_p(&drift, 1) < LEVEL.ln() && fit.estimates[0].abs() > PLAINLY * sd_um).then(|| {
        format!(
            "direction is {direction} in all rows, but each position was read twice in a cycle, there and back, and on the way back \
             the readings are {:.1} µm {} on average, as from the other side; if they were, give those rows direction {}",
            mean_um.abs(),
            if mean_um > 0.0 { "higher" } else { "lower" },
            -direction
        )
    })
}

/// The same of visits of a single position that are higher and lower in turn, beside a drift and its bend.
fn in_turn(comparison: &Comparison<'_>, direction: f64) -> Option<String> {
    let arrivals = comparison.arrivals.get(SETTLING..)?;
    if arrivals.len() < LEAST_VISITS {
        return None;
    }
    let read = arrivals.iter().map(|a| a.value_um).collect();
    let beside = [0, 1, 2].map(|power| arrivals.iter().map(|a| a.progress.powi(power)).collect());
    let drift = Projection::dense(read, &beside);
    let turns = [1.0, -1.0].into_iter().cycle().take(arrivals.len());
    let fit = Fit::new(&drift, &[turns.collect()]);
    (fit.ln_p(&drift, 1) < LEVEL.ln()).then(|| {
        format!(
            "direction is {direction} in all rows, but the readings are {:.1} µm higher and lower in turn, as from one side and the other; \
             if every other visit came from the other side, give it direction {}",
            2.0 * fit.estimates[0].abs(),
            -direction
        )
    })
}
