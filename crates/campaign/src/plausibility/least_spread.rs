//! Lengths that change less than any station could see.
//!
//! Each station is judged by all its series (one for each target); the bound is derived in [`super::moments`].

use std::collections::{BTreeMap, BTreeSet};

use super::hypothesis::Hypothesis;
use super::moments::Moments;
use super::nominal::NominalPoints;
use crate::Lengths;
use crate::reading::readings_of;

/// Part of the bound below which lengths are refused. The bound itself is exact for the nominal
/// motion; axis directions that are wrong by degrees change it by some per cent.
const BOUND_PART: f64 = 0.5;

/// Least bound that says anything, mm: beyond all errors of mounting and machine.
const LEAST_BOUND_MM: f64 = 5.0;

/// Without motion in three directions: part of the motion that must be seen from one station at
/// least, if there are [`STATIONS_NEEDED`]. Lengths in metres show a thousandth.
const LEAST_PART_OF_MOTION: f64 = 1.0 / 200.0;

/// Stations that nobody puts all where the motion is invisible.
const STATIONS_NEEDED: usize = 3;

/// Motion that counts as one, mm (standard deviation).
const LEAST_MOTION_MM: f64 = 10.0;

/// A series of lengths that changes too little.
pub(crate) struct TooSmall {
    pub(crate) station: usize,
    pub(crate) target: usize,
    /// First row of the series.
    pub(crate) line: usize,
    /// Standard deviation of the lengths, mm.
    pub(crate) spread_mm: f64,
    /// What it should be at least, mm.
    pub(crate) least_mm: f64,
}

/// The first station of which all lengths change too little, if there is one.
pub(crate) fn too_small(
    lengths: &Lengths,
    nominal: &NominalPoints,
    hypothesis: &Hypothesis,
) -> Option<TooSmall> {
    let series = series(lengths, nominal);
    let stations: BTreeSet<usize> = series.keys().map(|&(station, _)| station).collect();
    // The first series of a station if the lengths of all those for which `size_mm` is more than `least_size_mm`
    // spread less than `part` of it.
    let below = |station: usize, size_mm: fn(&Moments) -> f64, least_size_mm: f64, part: f64| {
        let own = series.range((station, 0)..=(station, usize::MAX));
        let sized = own.map(|(&(_, target), moments)| (target, moments, size_mm(moments)));
        let telling = sized.filter(|&(_, _, size_mm)| size_mm > least_size_mm);
        all_too_small(telling.map(|(target, moments, size_mm)| TooSmall {
            station,
            target,
            line: moments.line,
            spread_mm: moments.length_std_mm() * hypothesis.measured_factor(station),
            least_mm: part * size_mm,
        }))
    };
    let against_bound =
        |&station: &usize| below(station, Moments::least_std_mm, LEAST_BOUND_MM, BOUND_PART);
    if let Some(small) = stations.iter().find_map(against_bound) {
        return Some(small);
    }
    let against_motion = |&station: &usize| {
        let size_mm = Moments::motion_std_mm;
        below(station, size_mm, LEAST_MOTION_MM, LEAST_PART_OF_MOTION)
    };
    let all: Option<Vec<TooSmall>> = stations.iter().map(against_motion).collect();
    all.filter(|small| small.len() >= STATIONS_NEEDED)?
        .into_iter()
        .next()
}

/// The first of the series if all of them, and at least one, are too small.
fn all_too_small(series: impl Iterator<Item = TooSmall>) -> Option<TooSmall> {
    let mut first = None;
    for small in series {
        if small.spread_mm >= small.least_mm {
            return None;
        }
        first.get_or_insert(small);
    }
    first
}

fn series(lengths: &Lengths, nominal: &NominalPoints) -> BTreeMap<(usize, usize), Moments> {
    let mut series = BTreeMap::new();
    for stop in &lengths.stops {
        for reading in readings_of(stop, &lengths.readings) {
            let point = nominal.at(stop.step, reading.target);
            series
                .entry((stop.station, reading.target))
                .or_insert_with(|| Moments::starting_at(point, reading.length_mm, reading.line))
                .add(point, reading.length_mm);
        }
    }
    series.values_mut().for_each(Moments::find_sphere);
    for stop in &lengths.stops {
        for reading in readings_of(stop, &lengths.readings) {
            if let Some(moments) = series.get_mut(&(stop.station, reading.target)) {
                moments.enclose(nominal.at(stop.step, reading.target));
            }
        }
    }
    series
}
