//! Readings that were taken before the axis came to rest.
//!
//! Several readings of a stop scatter about their mean. Where they run on from the first to the last, and the other way
//! after an approach from the other side, the axis was still under way, and what was to come after the last of them is
//! a difference of the sides like lost motion. A drift runs the same way at all stops.

use trueaxis_campaign::VerificationReading;
use trueaxis_effects::Level;
use trueaxis_selection::{Fit, Hypothesis, Projection};

use crate::Rival;
use crate::verification::arrivals::Arrival;
use crate::verification::comparison::Comparison;
use crate::verification::lost_motion;
use crate::verification::wanderer::MACHINE;

/// Fewest stops with several readings.
const LEAST_STOPS: usize = 8;

/// Probability that an axis at rest counts as one under way.
const LEVEL: f64 = 1e-6;

/// From this part of the rms effect of lost motion, which is half of it, the sides may differ by nothing else.
const PART_OF_IT: f64 = 0.1;

/// By how much readings run on within a stop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Running {
    /// Mean from the first to the last, in the direction of the motion, µm.
    run_um: f64,
    stops: usize,
}

/// Whether the readings of the stops of an axis run on with its motion.
pub(crate) fn running(readings: &[VerificationReading], arrivals: &[Arrival]) -> Option<Running> {
    let mut rest = readings;
    let (mut runs, mut sides) = (Vec::new(), Vec::new());
    for arrival in arrivals {
        let own = rest.split_off(..arrival.readings)?;
        if let [first, .., last] = own {
            runs.push(last.value_um - first.value_um);
            sides.push(arrival.direction);
        }
    }
    let stops = runs.len();
    let has_both = sides.iter().any(|side| *side > 0.0) && sides.iter().any(|side| *side < 0.0);
    if stops < LEAST_STOPS || !has_both {
        return None;
    }
    let alike = Projection::dense(runs, &[vec![1.0; stops]]);
    let fit = Fit::new(&alike, &[sides]);
    (fit.ln_p(&alike, 1) < LEVEL.ln()).then(|| Running {
        run_um: fit.estimates[0],
        stops,
    })
}

/// What lost motion of the axis, with this effect on the readings (rms, µm), may be instead: the machine that still moves,
/// where what was still to come may be all of it.
pub(crate) fn instead(
    comparison: &Comparison<'_>,
    hypothesis: &Hypothesis,
    (rms_um, two_ln_b): (f64, f64),
) -> Option<Rival> {
    let is_it = |_: &Running| lost_motion::is_of_line(comparison, hypothesis);
    let running = comparison.running.filter(is_it)?;
    let rival = || Rival::of(Level::Verification, MACHINE, two_ln_b);
    (running.run_um.abs() > PART_OF_IT * rms_um).then(rival)
}

/// The notice about it.
pub(crate) fn doubt(comparison: &Comparison<'_>) -> Option<String> {
    let Running { run_um, stops } = comparison.running?;
    Some(format!(
        "from the first to the last reading of a stop the axis goes {:.1} µm {} (mean of {stops} stops): it was read before it came to rest, and \
         what was still to come is in the difference of the sides like lost motion; leave out the first readings of each stop, or wait longer",
        run_um.abs(),
        if run_um > 0.0 { "on" } else { "back" },
    ))
}
