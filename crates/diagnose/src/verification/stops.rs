//! Readings that contradict the others of their stop: in its mean they would be no slips any more, but scatter of the machine.
//!
//! Each stop has a mean; a reading is tested with what all others leave, those that stand out most first (externally studentised
//! residuals, as arrivals in [`super::gross_errors`]). It must be off by much more than the others of its stop differ, and than the
//! nearest stops at its position are from these; else the machine was on its way there, and the stop is looked at no further. Of two
//! readings neither is told from the other. Where more than a few stand out they are no slips but the way in which machine or
//! instrument settle, and stay.

use trueaxis_campaign::Verification;

use crate::selection::ln_f_test;
use crate::verification::base::cells;
use crate::verification::comparison::Comparison;
use crate::verification::gross_error::{Contradicts, GrossError};
use crate::verification::gross_errors::{IS_ON_ITS_WAY, LEAST_DEGREES_OF_FREEDOM, LEVEL, most};
use crate::verification::resolution::resolution_um;

/// The readings of a table that contradict others of their stops, in its order.
pub(crate) fn slips_within_stops(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<GrossError> {
    let readings = verification.readings.iter();
    let mut readings = readings.map(|reading| reading.value_um).enumerate();
    let arrivals = comparison.arrivals.iter();
    let mut stops: Vec<Vec<(usize, f64)>> = arrivals
        .map(|arrival| readings.by_ref().take(arrival.readings).collect())
        .collect();
    let cells = cells(comparison);
    let values_um = verification.readings.iter().map(|r| r.value_um);
    let resolution_um = resolution_um(values_um).unwrap_or_default();
    let count = verification.readings.len();
    let mut slips: Vec<(usize, Slip, Contradicts)> = Vec::new();
    // What is left at the last of them.
    let (mut found, mut variance) = (0, 0.0);
    let mut settled = vec![false; stops.len()];
    while let Some(slip) = largest(&stops, &settled) {
        let others = left(&stops, &settled, &slip, resolution_um);
        let drop = slip.error_um.powi(2) * slip.redundancy;
        let ln_p = ln_f_test(drop, drop + others.squares, 1, others.freedom + 1.0);
        let is_clear = ln_p < (LEVEL / count as f64).ln();
        if !is_clear || others.freedom < LEAST_DEGREES_OF_FREEDOM {
            break;
        }
        if found == most(count) {
            return Vec::new();
        }
        found += 1;
        if is_on_its_way(&stops, &cells, &slip) {
            settled[slip.stop] = true;
            continue;
        }
        variance = others.squares / others.freedom;
        let stop = &mut stops[slip.stop];
        match stop.len() {
            2 => {
                let other = Slip {
                    error_um: -slip.error_um,
                    ..slip
                };
                slips.push((stop[1 - slip.place].0, other, Contradicts::TheOther));
                slips.push((stop[slip.place].0, slip, Contradicts::TheOther));
                stop.clear();
            }
            _ => slips.push((stop.remove(slip.place).0, slip, Contradicts::ItsStop)),
        }
    }
    slips.sort_by_key(|(reading, ..)| *reading);
    let said = slips.into_iter().map(|(reading, slip, contradicts)| {
        let u_um = (variance / slip.redundancy).sqrt();
        GrossError::new(verification, reading, (slip.error_um, u_um), contradicts)
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
fn largest(stops: &[Vec<(usize, f64)>], settled: &[bool]) -> Option<Slip> {
    let stops = stops.iter().enumerate();
    let slips = stops
        .filter(|(stop, own)| own.len() > 1 && !settled[*stop])
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

/// Whether the machine was on its way when a reading was taken, as at the start of a warm-up: the others of its stop, or the nearest
/// stops before and after it at the same position, are not much nearer to each other.
fn is_on_its_way(stops: &[Vec<(usize, f64)>], cells: &[usize], slip: &Slip) -> bool {
    let near_um = IS_ON_ITS_WAY * slip.error_um.abs();
    let own = || stops[slip.stop].iter().enumerate();
    // Of two neither is known to be the slip.
    let is_other = |place: usize| place != slip.place || stops[slip.stop].len() == 2;
    let others = || own().filter(|(place, _)| is_other(*place));
    let others = || others().map(|(_, (_, value))| *value);
    let range_um =
        others().fold(f64::NEG_INFINITY, f64::max) - others().fold(f64::INFINITY, f64::min);
    if stops[slip.stop].len() > 2 && range_um > near_um {
        return true;
    }
    let is_same = |other: &usize| cells[*other] == cells[slip.stop] && !stops[*other].is_empty();
    let before = (0..slip.stop).rev().find(is_same);
    let after = (slip.stop + 1..stops.len()).find(is_same);
    [before, after].into_iter().flatten().any(|neighbour| {
        let values = stops[neighbour].iter().map(|(_, value)| value);
        let mean = values.sum::<f64>() / stops[neighbour].len() as f64;
        others().all(|value| (value - mean).abs() > near_um)
    })
}

/// What the readings of stops scatter by.
struct Left {
    squares: f64,
    freedom: f64,
}

/// Without one, and by no less than the last digit.
fn left(stops: &[Vec<(usize, f64)>], settled: &[bool], without: &Slip, resolution_um: f64) -> Left {
    let (mut squares, mut freedom) = (0.0, 0.0);
    let all = stops.iter().enumerate();
    for (number, stop) in all.filter(|(number, _)| !settled[*number]) {
        let is_out = |place: usize| (without.stop, without.place) == (number, place);
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
