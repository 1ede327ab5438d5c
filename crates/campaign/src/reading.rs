//! What a length and a measured point have in common.

use crate::{LengthReading, PointReading, Stop};

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

/// The readings taken at `stop`.
pub(crate) fn readings_of<'r, R>(stop: &Stop, readings: &'r [R]) -> &'r [R] {
    readings.get(stop.readings.clone()).unwrap_or_default()
}
