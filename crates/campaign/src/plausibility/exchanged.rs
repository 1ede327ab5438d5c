//! Points of a stop under each other's names.
//!
//! The distances between the targets of a stop are then those between other targets. Nests are mounted by hand, so that an exchange is
//! believed only if the distances are wrong by more than that and right, in comparison, with the two names exchanged.

use std::collections::BTreeMap;

use nalgebra::distance;

use super::nominal::NominalPoints;
use crate::{Campaign, PointReading, Points, Stop};

/// Distances that differ by less than this, mm, may be of nests that are not quite where they should be.
const BY_HAND_MM: f64 = 5.0;

/// Part of the largest difference that may be left with two names exchanged.
const RIGHT: f64 = 0.2;

/// Two targets with the lines of the first and the last of their stops, and the number of these.
type Exchanged = ([usize; 2], usize);

/// Notices on targets that have each other's names at some stops, but not at most: then their nominal positions are exchanged.
pub(super) fn notices(
    name: &str,
    campaign: &Campaign,
    points: &Points,
    nominal: &NominalPoints,
) -> Vec<String> {
    let mut all: BTreeMap<[usize; 2], Exchanged> = BTreeMap::new();
    for stop in &points.stops {
        let readings = &points.readings[stop.readings.clone()];
        if let (Some(pair), [first, .., last]) = (exchanged(stop, readings, nominal), readings) {
            let (lines, count) = all.entry(pair).or_insert(([first.line; 2], 0));
            lines[1] = last.line;
            *count += 1;
        }
    }
    let some = all
        .into_iter()
        .filter(|(_, (_, count))| 2 * count < points.stops.len());
    let said = some.map(|([a, b], ([first, last], count))| {
        let [a, b] = [a, b].map(|target| &campaign.targets[target].name);
        format!(
            "{name} lines {first} to {last}: targets `{a}` and `{b}` have each other's names at {count} of {} stops: only with them exchanged are \
             the distances between the targets those of the other stops; exchange the names in these rows",
            points.stops.len()
        )
    });
    said.collect()
}

/// The two targets of a stop whose exchange makes its distances right.
fn exchanged(
    stop: &Stop,
    readings: &[PointReading],
    nominal: &NominalPoints,
) -> Option<[usize; 2]> {
    let difference_mm = |of: &dyn Fn(usize) -> usize| {
        let mut largest_mm = 0.0_f64;
        for (i, a) in readings.iter().enumerate() {
            for b in &readings[..i] {
                let [p, q] = [a, b].map(|r| nominal.at(stop.step, of(r.target)));
                let measured_mm = distance(&a.position_mm, &b.position_mm);
                largest_mm = largest_mm.max((measured_mm - distance(&p, &q)).abs());
            }
        }
        largest_mm
    };
    let as_given_mm = difference_mm(&|target| target);
    if as_given_mm < BY_HAND_MM {
        return None;
    }
    let pairs = (0..readings.len()).flat_map(|i| (0..i).map(move |k| [k, i]));
    let pairs = pairs.map(|pair| pair.map(|i| readings[i].target));
    let left_mm = |[a, b]: [usize; 2]| {
        difference_mm(&|target| match target {
            _ if target == a => b,
            _ if target == b => a,
            _ => target,
        })
    };
    let best = pairs
        .map(|pair| (pair, left_mm(pair)))
        .min_by(|a, b| a.1.total_cmp(&b.1));
    let (mut pair, left_mm) = best?;
    pair.sort_unstable();
    (left_mm < RIGHT * as_given_mm).then_some(pair)
}
