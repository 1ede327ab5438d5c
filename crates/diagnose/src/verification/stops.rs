//! Readings that contradict the others of their stop: in its mean they would be no slips any more, but scatter of the machine.
//!
//! Each stop has a mean; a reading is tested with what all others leave, those that stand out most first (externally studentised
//! residuals, as arrivals in [`super::gross_errors`]). It must be off by more than the nearest stops at its position are. Of two readings neither is told from the other. More than a few are no slips but
//! the way in which machine or instrument settle, and stay.

use trueaxis_campaign::Verification;

use crate::Rejected;
use crate::selection::ln_f_test;
use crate::verification::base::cells;
use crate::verification::comparison::Comparison;
use crate::verification::gross_errors::{LEAST_DEGREES_OF_FREEDOM, LEVEL, MOST, ONE_OF_TWO};
use crate::verification::resolution::resolution_um;

pub(crate) const OF_STOP: &str =
    "contradicts the other readings of its stop: a slip of the pen, or of the instrument";

/// The readings of a table that contradict others of their stops: their indices, and what is said of them.
pub(crate) fn slips_within_stops(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<(usize, Rejected)> {
    let readings = verification.readings.iter();
    let mut readings = readings.map(|reading| reading.value_um).enumerate();
    let arrivals = comparison.arrivals.iter();
    let mut stops: Vec<Vec<(usize, f64)>> = arrivals
        .map(|arrival| readings.by_ref().take(arrival.readings).collect())
        .collect();
    let cells = cells(comparison);
    let resolution_um = resolution_um(comparison).unwrap_or_default();
    let count = verification.readings.len() as f64;
    let mut slips: Vec<(usize, Slip, &str)> = Vec::new();
    for found in 0.. {
        let Some(slip) = largest(&stops) else {
            break;
        };
        let others = left(&stops, Some(&slip), resolution_um);
        let drop = slip.error_um.powi(2) * slip.redundancy;
        let ln_p = ln_f_test(drop, drop + others.squares, 1, others.freedom + 1.0);
        let is_clear = ln_p < (LEVEL / count).ln();
        if !is_clear || others.freedom < LEAST_DEGREES_OF_FREEDOM {
            break;
        }
        if f64::from(found) >= (MOST * count).max(1.0) {
            return Vec::new();
        }
        let contradicts = contradicts_neighbours(&stops, &cells, &slip);
        let stop = &mut stops[slip.stop];
        match stop.len() {
            _ if !contradicts => stop.clear(),
            2 => {
                let other = Slip {
                    error_um: -slip.error_um,
                    ..slip
                };
                slips.push((stop[1 - slip.place].0, other, ONE_OF_TWO));
                slips.push((stop[slip.place].0, slip, ONE_OF_TWO));
                stop.clear();
            }
            _ => slips.push((stop.remove(slip.place).0, slip, OF_STOP)),
        }
    }
    slips.sort_by_key(|(reading, ..)| *reading);
    let left = left(&stops, None, resolution_um);
    let said = slips.into_iter().map(|(reading, slip, reason)| {
        let rejected = Rejected {
            file: verification.name.clone(),
            row: verification.readings[reading].line,
            error_um: slip.error_um,
            u_um: (left.squares / left.freedom / slip.redundancy).sqrt(),
            reason: reason.to_owned(),
        };
        (reading, rejected)
    });
    said.collect()
}

/// A reading of a stop, and how far it is off the mean of the others there.
#[derive(Debug, Clone, Copy)]
struct Slip {
    stop: usize,
    place: usize,
    error_um: f64,
    /// Part of an error that the residual shows.
    redundancy: f64,
}

/// The reading that stands out most among those of its stop.
fn largest(stops: &[Vec<(usize, f64)>]) -> Option<Slip> {
    let stops = stops.iter().enumerate();
    let slips = stops
        .filter(|(_, own)| own.len() > 1)
        .flat_map(|(stop, own)| {
            let redundancy = 1.0 - 1.0 / own.len() as f64;
            let mean = own.iter().map(|(_, value)| value).sum::<f64>() / own.len() as f64;
            own.iter().enumerate().map(move |(place, (_, value))| Slip {
                stop,
                place,
                error_um: (value - mean) / redundancy,
                redundancy,
            })
        });
    let drop = |slip: &Slip| slip.error_um.powi(2) * slip.redundancy;
    slips.max_by(|a, b| drop(a).total_cmp(&drop(b)))
}

/// Whether a slip is larger than what lies between its stop and those before and after it at the same position: otherwise the machine
/// was on its way, as at the start of a warm-up.
fn contradicts_neighbours(stops: &[Vec<(usize, f64)>], cells: &[usize], slip: &Slip) -> bool {
    let is_same = |other: &usize| cells[*other] == cells[slip.stop] && !stops[*other].is_empty();
    let before = (0..slip.stop).rev().find(is_same);
    let after = (slip.stop + 1..stops.len()).find(is_same);
    [before, after].into_iter().flatten().all(|other| {
        let values = stops[other].iter().map(|(_, value)| value);
        let mean = values.sum::<f64>() / stops[other].len() as f64;
        let own = stops[slip.stop].iter();
        own.map(|(_, value)| (value - mean).abs())
            .fold(f64::INFINITY, f64::min)
            < slip.error_um.abs()
    })
}

/// What the readings of stops scatter by.
struct Left {
    squares: f64,
    freedom: f64,
}

/// Without one, and by no less than the last digit.
fn left(stops: &[Vec<(usize, f64)>], without: Option<&Slip>, resolution_um: f64) -> Left {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for (number, stop) in stops.iter().enumerate() {
        let is_out =
            |place: usize| without.is_some_and(|slip| (slip.stop, slip.place) == (number, place));
        let own = stop.iter().enumerate().filter(|(place, _)| !is_out(*place));
        let own: Vec<f64> = own.map(|(_, (_, value))| *value).collect();
        let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
        squares += own.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        freedom += own.len().saturating_sub(1) as f64;
    }
    Left {
        squares: squares.max(freedom * resolution_um.powi(2)),
        freedom,
    }
}
