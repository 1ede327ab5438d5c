//! Readings that contradict the others of their stop: in its mean they would look like scatter of the machine.
//!
//! Each stop has a mean; a reading is tested with what all others leave, those that stand out most first
//! ([`Tested`], as for arrivals in [`super::gross_errors`]). It must be off by much more than the others of
//! its stop differ, and the nearest stops at its position from these; otherwise the machine was on its way there, and
//! the stop is not considered further. Of two readings nothing shows which is wrong. Where more than a few stand out
//! they are no gross errors but the way in which machine or instrument settle, and stay.

use trueaxis_campaign::Verification;
use trueaxis_selection::Gram;

use crate::engine::{ACCIDENT_LEVEL, ACCIDENTS, LEAST_OTHERS, Tested, most};
use crate::numbers::extremes;
use crate::verification::base::cells;
use crate::verification::comparison::Comparison;
use crate::verification::gross_error::{Contradicts, GrossError};
use crate::verification::gross_errors::IS_ON_ITS_WAY;
use crate::verification::resolution::resolution_um;

/// The readings of a table that contradict others of their stops, in its order.
pub(crate) fn gross_errors_within_stops(
    verification: &Verification,
    comparison: &Comparison<'_>,
) -> Vec<GrossError> {
    let values_um = || verification.readings.iter().map(|r| r.value_um);
    let mut readings = values_um().enumerate();
    let arrivals = comparison.arrivals.iter().zip(cells(comparison));
    let stops = arrivals.map(|(arrival, cell)| Stop {
        cell,
        readings: readings.by_ref().take(arrival.readings).collect(),
        is_excluded: false,
    });
    let mut stops: Vec<Stop> = stops.collect();
    let resolution_um = resolution_um(values_um()).unwrap_or_default();
    let count = verification.readings.len();
    let mut outliers: Vec<(usize, Outlier, Contradicts)> = Vec::new();
    // What is left at the last of them.
    let (mut found, mut variance) = (0, 0.0);
    while let Some(outlier) = largest(&stops) {
        let (squares, freedom) = left(&stops);
        let gram = Gram::new(&[outlier.redundancy], &[1.0]);
        let residual = [outlier.error_um * outlier.redundancy];
        let tested = Tested::new(
            (squares, freedom),
            (&gram, &residual),
            resolution_um.powi(2),
        );
        let is_clear = tested.ln_p < (ACCIDENT_LEVEL / count as f64).ln();
        if !is_clear || freedom - 1.0 < LEAST_OTHERS {
            break;
        }
        if found == most(ACCIDENTS, count) {
            return Vec::new();
        }
        found += 1;
        if is_on_its_way(&stops, &outlier) {
            stops[outlier.stop].is_excluded = true;
            continue;
        }
        variance = tested.covariance[0] * outlier.redundancy;
        let readings = &mut stops[outlier.stop].readings;
        match readings.len() {
            2 => {
                let other = Outlier {
                    error_um: -outlier.error_um,
                    ..outlier
                };
                outliers.push((readings[1 - outlier.place].0, other, Contradicts::TheOther));
                outliers.push((readings[outlier.place].0, outlier, Contradicts::TheOther));
                readings.clear();
            }
            _ => outliers.push((
                readings.remove(outlier.place).0,
                outlier,
                Contradicts::ItsStop,
            )),
        }
    }
    outliers.sort_by_key(|(reading, ..)| *reading);
    let said = outliers.into_iter().map(|(reading, outlier, contradicts)| {
        let u_um = (variance / outlier.redundancy).sqrt();
        GrossError::new(verification, reading, (outlier.error_um, u_um), contradicts)
    });
    said.collect()
}

/// What is left of the readings of a stop.
struct Stop {
    /// The index of its position and side.
    cell: usize,
    /// Their indices and values, µm.
    readings: Vec<(usize, f64)>,
    /// Whether nothing more is to be tested here: the machine was on its way.
    is_excluded: bool,
}

impl Stop {
    fn mean(&self) -> f64 {
        self.readings.iter().map(|(_, value)| value).sum::<f64>() / self.readings.len() as f64
    }
}

/// A reading of a stop, and how far it is off the mean of the others there.
#[derive(Debug, Clone, Copy)]
struct Outlier {
    stop: usize,
    place: usize,
    error_um: f64,
    /// Share of an error that the residual shows.
    redundancy: f64,
}

/// The reading that stands out most among those of its stop.
fn largest(stops: &[Stop]) -> Option<Outlier> {
    let stops = stops.iter().enumerate();
    let outliers = stops
        .filter(|(_, own)| own.readings.len() > 1 && !own.is_excluded)
        .flat_map(|(stop, own)| {
            let (redundancy, mean) = (1.0 - 1.0 / own.readings.len() as f64, own.mean());
            let readings = own.readings.iter().enumerate();
            readings.map(move |(place, (_, value))| Outlier {
                stop,
                place,
                error_um: (value - mean) / redundancy,
                redundancy,
            })
        });
    let drop = |outlier: &Outlier| outlier.error_um.powi(2) * outlier.redundancy;
    outliers.max_by(|a, b| drop(a).total_cmp(&drop(b)))
}

/// Whether the machine was on its way when a reading was taken, as at the start of a warm-up: the others of its stop,
/// or the nearest stops before and after it at the same position, are not much nearer to each other.
fn is_on_its_way(stops: &[Stop], outlier: &Outlier) -> bool {
    let near_um = IS_ON_ITS_WAY * outlier.error_um.abs();
    let own = &stops[outlier.stop];
    // Of two neither is known to be the gross error.
    let is_known = own.readings.len() > 2;
    let all = own.readings.iter().enumerate();
    let others = all.filter(|(place, _)| !is_known || *place != outlier.place);
    let others: Vec<f64> = others.map(|(_, (_, value))| *value).collect();
    let [low, high] = extremes(others.iter().copied());
    if is_known && high - low > near_um {
        return true;
    }
    let is_same = |other: &&Stop| other.cell == own.cell && !other.readings.is_empty();
    let before = stops[..outlier.stop].iter().rev().find(is_same);
    let after = stops[outlier.stop + 1..].iter().find(is_same);
    let is_far = |neighbour: &Stop, value: &f64| (value - neighbour.mean()).abs() > near_um;
    // Of two the first is as before and the second as after: something jumped between them.
    if let ([first, second], Some(before), Some(after)) = (&others[..], before, after)
        && !is_known
        && is_far(before, second)
        && is_far(after, first)
    {
        return true;
    }
    let mut neighbours = [before, after].into_iter().flatten();
    neighbours.any(|neighbour| others.iter().all(|value| is_far(neighbour, value)))
}

/// Sum of squares of the readings about their stops' means, with its freedom.
fn left(stops: &[Stop]) -> (f64, f64) {
    let own = stops
        .iter()
        .filter(|stop| !stop.is_excluded && !stop.readings.is_empty());
    own.fold((0.0, 0.0), |(squares, freedom), stop| {
        let (mean, values) = (stop.mean(), stop.readings.iter());
        let own: f64 = values.map(|(_, value)| (value - mean).powi(2)).sum();
        (squares + own, freedom + (stop.readings.len() - 1) as f64)
    })
}
