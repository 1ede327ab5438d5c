//! How many of the stated 95 % intervals hold the truth.

use trueaxis_calibrate::Calibration;
use trueaxis_simulate::Truth;

use crate::{Deviation, components, locations, stations};

/// Counts by kind of output.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Component errors.
    pub components: Share,
    /// Location errors.
    pub locations: Share,
    /// Coordinates and dead paths of stations.
    pub stations: Share,
}

/// So many of so many.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Share {
    /// Intervals that hold the truth.
    pub inside: u64,
    /// All of them.
    pub all: u64,
}

impl Tally {
    /// Of one campaign.
    pub fn of(calibration: &Calibration, truth: &Truth) -> Self {
        Self {
            components: Share::of(&components(calibration, truth)),
            locations: Share::of(&locations(calibration, truth)),
            stations: Share::of(&stations(calibration, truth)),
        }
    }

    /// Adds the counts of another campaign.
    pub fn add(&mut self, other: Self) {
        for (sum, share) in [
            (&mut self.components, other.components),
            (&mut self.locations, other.locations),
            (&mut self.stations, other.stations),
        ] {
            sum.inside += share.inside;
            sum.all += share.all;
        }
    }
}

impl Share {
    /// Of some numbers.
    pub fn of(all: &[Deviation]) -> Self {
        let judged: Vec<bool> = all.iter().filter_map(Deviation::is_inside).collect();
        Self {
            inside: judged.iter().filter(|inside| **inside).count() as u64,
            all: judged.len() as u64,
        }
    }

    /// In per cent.
    pub fn per_cent(&self) -> f64 {
        100.0 * self.inside as f64 / self.all as f64
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:.1} % of {}", self.per_cent(), self.all)
    }
}
