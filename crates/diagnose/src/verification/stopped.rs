//! Whether an axis stopped at its positions, as uneven steps and their times show.
//!
//! On the fly a longer step takes more time, in proportion; an axis that stops takes a time of its own at each position.
//! Steps and times count in units of their means over the pass, so that feeds may differ. At the ends of a pass it
//! speeds up and slows down; these steps do not count.

use trueaxis_selection::{Fit, Projection};

use crate::numbers::mean;
use crate::verification::arrivals::Arrival;

/// Fewest steps.
const LEAST_STEPS: usize = 12;

/// Least standard deviation of the steps, as a share of their mean.
const UNEVEN: f64 = 0.05;

/// Probability that an axis that did not stop counts as one that did, in times with white noise.
const LEVEL: f64 = 1e-6;

/// Least share of the time between two positions that does not grow with their distance.
const MOST_OF_TIME: f64 = 0.5;

/// Whether the times of a line tell that its axis stopped at its positions.
pub(crate) fn is_stopped(all: &[Arrival], axis: usize) -> bool {
    let (mut steps, mut times) = (Vec::new(), Vec::new());
    for pass in all.chunk_by(Arrival::is_of_pass) {
        let Some(inner) = pass.get(1..pass.len() - 1) else {
            continue;
        };
        let of_two = |of: &dyn Fn(&Arrival) -> f64| {
            let two = inner.windows(2);
            let all: Vec<f64> = two.map(|two| (of(&two[1]) - of(&two[0])).abs()).collect();
            let mean = mean(&all);
            all.into_iter().map(move |own| own / mean)
        };
        steps.extend(of_two(&|a| a.positions[axis]));
        times.extend(of_two(&|a| a.time_s));
    }
    let n = steps.len();
    let uneven = steps.iter().map(|step| (step - 1.0).powi(2)).sum::<f64>() / n as f64;
    // Without a step or a duration in a pass its mean is zero.
    let is_told = steps.iter().chain(&times).all(|own| own.is_finite());
    if n < LEAST_STEPS || !is_told || uneven.sqrt() < UNEVEN {
        return false;
    }
    let on_the_fly = Projection::dense(times, &[steps]);
    let fit = Fit::new(&on_the_fly, &[vec![1.0; n]]);
    fit.ln_p(&on_the_fly, 1) < LEVEL.ln() && fit.estimates[0] > MOST_OF_TIME
}
