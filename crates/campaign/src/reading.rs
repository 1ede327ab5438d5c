//! What a length and a measured point have in common.

use crate::{Campaign, LengthReading, PointReading, Stop};

/// A reading of a target at a time.
pub(crate) trait Reading {
    /// Whether its file has a column `station`.
    const HAS_STATION: bool;

    fn time_s(&self) -> f64;
    fn target(&self) -> usize;
    fn line(&self) -> usize;

    /// What was read, mm.
    fn values(&self) -> [f64; 3];
}

impl Reading for LengthReading {
    const HAS_STATION: bool = true;

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn target(&self) -> usize {
        self.target
    }

    fn line(&self) -> usize {
        self.line
    }

    fn values(&self) -> [f64; 3] {
        [self.length_mm, 0.0, 0.0]
    }
}

impl Reading for PointReading {
    const HAS_STATION: bool = false;

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn target(&self) -> usize {
        self.target
    }

    fn line(&self) -> usize {
        self.line
    }

    fn values(&self) -> [f64; 3] {
        self.position_mm.coords.into()
    }
}

/// When which target was read, and where that stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Time since the start of the campaign, s.
    pub time_s: f64,
    /// Target measured.
    pub target: usize,
    /// Line of the file, from 1 (the header).
    pub line: usize,
}

impl Sighting {
    fn of(reading: &impl Reading) -> Self {
        Self {
            time_s: reading.time_s(),
            target: reading.target(),
            line: reading.line(),
        }
    }
}

impl Campaign {
    /// The stops of the lengths, or of the points.
    pub fn stops(&self) -> &[Stop] {
        match (&self.lengths, &self.points) {
            (Some(lengths), _) => &lengths.stops,
            (None, Some(points)) => &points.stops,
            (None, None) => &[],
        }
    }

    /// The length, or the point, with this number.
    pub fn sighting(&self, number: usize) -> Option<Sighting> {
        match (&self.lengths, &self.points) {
            (Some(lengths), _) => lengths.readings.get(number).map(Sighting::of),
            (None, points) => points.as_ref()?.readings.get(number).map(Sighting::of),
        }
    }

    /// Those of one of its stops.
    pub fn sightings(&self, stop: &Stop) -> impl DoubleEndedIterator<Item = Sighting> + '_ {
        let numbers = stop.readings.clone();
        numbers.filter_map(|number| self.sighting(number))
    }
}

pub(crate) fn readings_of<'r, R>(stop: &Stop, readings: &'r [R]) -> &'r [R] {
    readings.get(stop.readings.clone()).unwrap_or_default()
}
