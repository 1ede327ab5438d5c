//! Lengths left out as gross errors, and whether the causes explain them after all.
//!
//! The few lengths between a slip and the end of an occupation look like accidents until the slip is known. Nor is
//! its instant known without them; so the causes are sought again with them. And several consecutive ones to one target,
//! or from one station, are no accidents.

use std::collections::BTreeMap;
use std::ops::Range;

use trueaxis_campaign::{Campaign, Lengths, Stop};
use trueaxis_effects::Shape;
use trueaxis_leastsquares::median;
use trueaxis_multilateration::Network;
use trueaxis_poses::{Group, LengthCircumstances as Reading, length_circumstances};
use trueaxis_screening::{Removed, is_concentrated};

use crate::engine::{Suspect, most};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;

/// A length that was left out.
#[derive(Debug, Clone)]
pub(crate) struct LeftOut {
    /// The result of the screening; its reading is the index among the lengths of the campaign.
    pub(crate) removed: Removed,
    /// Its line in the file.
    pub(crate) line: usize,
    reading: Reading,
    measured_mm: f64,
}

/// A misfit of up to this many standard deviations agrees: noise exceeds it once in 16,000 lengths.
const AGREES: f64 = 4.0;

impl LeftOut {
    /// The readings that were `removed` (ascending).
    pub(crate) fn of(
        campaign: &Campaign,
        lengths: &Lengths,
        network: &Network,
        groups: &[Group],
        removed: &[Removed],
    ) -> Vec<Self> {
        let numbers: Vec<usize> = removed.iter().map(|removed| removed.reading).collect();
        let readings = length_circumstances(campaign, lengths, network, groups, &numbers);
        let left_out = removed.iter().zip(readings);
        let left_out = left_out.map(|(&removed, reading)| Self {
            removed,
            line: lengths.readings[removed.reading].line,
            reading,
            measured_mm: network.readings[removed.reading].length_mm,
        });
        left_out.collect()
    }

    /// Whether the causes explain it, as they are or with their instants on its other side: an instant that was found
    /// without the length is uncertain there.
    fn is_explained(&self, base: &Base<'_>, adjusted: &Adjusted) -> bool {
        let shifted = |instant: f64| -> Vec<Suspect> {
            let mut suspects = adjusted.suspects.clone();
            for suspect in &mut suspects {
                if suspect.hypothesis.effect.shape == Shape::Instant {
                    suspect.shape = instant;
                }
            }
            suspects
        };
        let alternatives = [
            adjusted.suspects.clone(),
            shifted(f64::NEG_INFINITY),
            shifted(f64::INFINITY),
        ];
        let solution = &adjusted.solution;
        let station = &solution.stations[self.reading.station];
        let distance_mm = (solution.points_mm[self.reading.point] - station.position_mm).norm();
        let noise = &adjusted.network.noise;
        let sigma_mm = noise
            .length_sigma_at_mm(distance_mm)
            .hypot(noise.repeatability_mm);
        let (station, point) = (self.reading.station, self.reading.point);
        let misfit_mm =
            self.measured_mm - solution.computed_length_mm(&adjusted.network, station, point);
        alternatives.iter().any(|suspects| {
            let effect_mm = base.effect_mm(&self.reading, solution, suspects);
            (misfit_mm - effect_mm).abs() <= AGREES * sigma_mm
        })
    }
}

/// The lengths of `all` that are isolated and that the causes of a model, if there are any, do not explain.
pub(crate) fn still_left_out(
    all: &[LeftOut],
    base: &Base<'_>,
    lengths: &Lengths,
    adjusted: &Adjusted,
) -> Vec<Removed> {
    let is_gross = |l: &&LeftOut| adjusted.suspects.is_empty() || !l.is_explained(base, adjusted);
    alone(all.iter().filter(is_gross), lengths)
}

/// The lengths that are neither consecutive, nor most of all and to one target from one station.
pub(crate) fn alone<'l>(
    all: impl IntoIterator<Item = &'l LeftOut>,
    lengths: &Lengths,
) -> Vec<Removed> {
    let all: Vec<&LeftOut> = all.into_iter().collect();
    let numbers: Vec<usize> = all.iter().map(|l| l.removed.reading).collect();
    let together = [in_a_row(&numbers, lengths), concentrated(&all)];
    let is_alone = |l: &&&LeftOut| {
        together
            .iter()
            .all(|some| !some.contains(&l.removed.reading))
    };
    all.iter().filter(is_alone).map(|l| l.removed).collect()
}

/// A length that is off by more than this many times the median of many was wrong in addition.
const FAR: f64 = 5.0;

/// The lengths to one target from one station, if they are most of all, ascending.
fn concentrated(all: &[&LeftOut]) -> Vec<usize> {
    let mut parts: BTreeMap<(usize, usize), Vec<&LeftOut>> = BTreeMap::new();
    for left_out in all {
        let part = (left_out.reading.station, left_out.reading.target);
        parts.entry(part).or_default().push(left_out);
    }
    let mut many = parts.into_values();
    let many = many.find(|part| is_concentrated(part.len(), all.len()));
    let many = many.unwrap_or_default();
    let size = |left_out: &&LeftOut| left_out.removed.error_mm.abs();
    let median = median(&mut many.iter().map(size).collect::<Vec<f64>>());
    let most = median.map_or(0.0, |median| FAR * median);
    let of_them = many.iter().filter(|left_out| size(left_out) <= most);
    of_them.map(|left_out| left_out.removed.reading).collect()
}

/// Fewest consecutive wrong lengths that are no accidents.
const LEAST_IN_A_ROW: i32 = 3;

/// So many consecutive wrong lengths are never accidents.
const LONG: i32 = 10;

/// Largest expected number of such sequences by accident in a campaign.
const ACCIDENTAL_ROWS: f64 = 0.01;

/// Consecutive stops that are no accidents, as many as a jump has on its far side; fewer may be read too early.
const STOPS_IN_A_ROW: usize = 4;

/// Share of the stops that may be such accidents.
const FEW_STOPS: f64 = 0.01;

/// Consecutive readings among `numbers` (ascending): as many to one target as accidents hardly ever produce (three if
/// one in a hundred is wrong, four if two are), or one more from one station. A stop that is off as a whole is one
/// accident, except at the ends of a station's readings, where a tripod settles or moved.
fn in_a_row(numbers: &[usize], lengths: &Lengths) -> Vec<usize> {
    let all = lengths.readings.len() as f64;
    let share = numbers.len() as f64 / all.max(1.0);
    let accidental = |count: i32| all * share.powi(count);
    let least = (LEAST_IN_A_ROW..LONG).find(|&count| accidental(count) < ACCIDENTAL_ROWS);
    let least = usize::try_from(least.unwrap_or(LONG)).unwrap_or(usize::MAX);
    let mut rows: BTreeMap<(usize, Option<usize>), Vec<usize>> = BTreeMap::new();
    let mut found = Vec::new();
    let is_one = |number: usize| numbers.binary_search(&number).is_ok();
    let is_whole = |stop: &&Stop| stop.readings.len() > 1 && stop.readings.clone().all(is_one);
    let whole = lengths.stops.iter().filter(is_whole).count();
    let are_few = whole <= most(FEW_STOPS, lengths.stops.len());
    // For each station whether any stop was in order yet, and the present sequence of those that were not.
    let mut stops: BTreeMap<usize, (bool, Vec<Range<usize>>)> = BTreeMap::new();
    for stop in &lengths.stops {
        let (is_after, whole) = stops.entry(stop.station).or_default();
        if are_few && is_whole(&stop) {
            whole.push(stop.readings.clone());
            if !*is_after || whole.len() >= STOPS_IN_A_ROW {
                found.extend(whole.iter().cloned().flatten());
            }
            continue;
        }
        whole.clear();
        *is_after = true;
        for number in stop.readings.clone() {
            let is_one = is_one(number);
            let target = lengths.readings[number].target;
            for (of, least) in [(Some(target), least), (None, least + 1)] {
                let row = rows.entry((stop.station, of)).or_default();
                match is_one {
                    true => row.push(number),
                    false => row.clear(),
                }
                if row.len() >= least {
                    found.extend(&*row);
                }
            }
        }
    }
    let at_the_end = stops.into_values().flat_map(|(_, whole)| whole);
    found.extend(at_the_end.flatten());
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use trueaxis_campaign::{Direction, LengthReading};

    use super::*;

    /// Stops of three targets from one station.
    fn lengths(stops: usize) -> Lengths {
        let reading = |number: usize| LengthReading {
            time_s: number as f64,
            target: number % 3,
            length_mm: 0.0,
            line: number + 2,
        };
        let stop = |step: usize| Stop {
            station: 0,
            repeat: 1,
            step,
            direction: Direction::Forward,
            readings: 3 * step..3 * step + 3,
        };
        Lengths {
            stops: (0..stops).map(stop).collect(),
            readings: (0..3 * stops).map(reading).collect(),
            logged: Vec::new(),
        }
    }

    /// A machine that had not arrived at three stops is three accidents; a tripod that was elsewhere at four stops is
    /// none, nor is a target that was elsewhere at four.
    #[test]
    fn stops_as_a_whole_are_one_accident_each() {
        let lengths = lengths(600);
        let three: Vec<usize> = (30..39).collect();
        assert_eq!(in_a_row(&three, &lengths), [0; 0]);
        let four: Vec<usize> = (30..42).collect();
        assert_eq!(in_a_row(&four, &lengths), four);
        let first: Vec<usize> = (0..6).collect();
        assert_eq!(in_a_row(&first, &lengths), first);
        let last: Vec<usize> = (1794..1800).collect();
        assert_eq!(in_a_row(&last, &lengths), last);
        let of_one_target: Vec<usize> = (0..4).map(|stop| 30 + 3 * stop).collect();
        assert_eq!(in_a_row(&of_one_target, &lengths), of_one_target);
    }
}
