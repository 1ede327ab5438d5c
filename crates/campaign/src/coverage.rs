//! Which target was read from which station in which run, and where it was not.

use std::collections::{BTreeMap, BTreeSet};

use crate::reading::{Reading, readings_of};
use crate::{Campaign, Stop};

/// How often a target was read in a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// The run.
    pub run: usize,
    /// The target.
    pub target: usize,
    /// Steps of the run.
    pub steps_of_run: usize,
    /// From each station in the order of the campaign; a single entry in a points campaign.
    pub seen: Vec<Seen>,
}

/// What was read of a target in a run from one station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Seen {
    /// Readings.
    pub readings: usize,
    /// Steps with a reading at least.
    pub steps: usize,
}

/// What lacks from a station, the greatest lack first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hole {
    /// No reading at all.
    NotSeen,
    /// No reading at some steps of the run.
    Steps,
    /// All steps, but fewer readings than from another station.
    Readings,
}

impl Coverage {
    /// What lacks from that station; nothing for one that does not exist.
    pub fn hole(&self, station: usize) -> Option<Hole> {
        let seen = self.seen.get(station)?;
        let most = self.seen.iter().map(|seen| seen.readings).max();
        if seen.readings == 0 {
            Some(Hole::NotSeen)
        } else if seen.steps < self.steps_of_run {
            Some(Hole::Steps)
        } else if Some(seen.readings) < most {
            Some(Hole::Readings)
        } else {
            None
        }
    }
}

impl Campaign {
    /// How often each target was read in each run in which any station saw it, by run and target.
    pub fn coverage(&self) -> Vec<Coverage> {
        match (&self.lengths, &self.points) {
            (Some(lengths), _) => self.covered(&lengths.stops, &lengths.readings),
            (None, Some(points)) => self.covered(&points.stops, &points.readings),
            (None, None) => Vec::new(),
        }
    }

    fn covered<R: Reading>(&self, stops: &[Stop], readings: &[R]) -> Vec<Coverage> {
        let stations = if R::HAS_STATION {
            self.stations.len()
        } else {
            1
        };
        let mut steps_of_run = vec![0; self.runs.len()];
        for step in &self.steps {
            steps_of_run[step.run] += 1;
        }
        let mut found: BTreeMap<(usize, usize), Vec<Seen>> = BTreeMap::new();
        let mut seen_steps = BTreeSet::new();
        for stop in stops {
            let run = self.steps[stop.step].run;
            for reading in readings_of(stop, readings) {
                let target = reading.target();
                let by_station = found.entry((run, target)).or_default();
                by_station.resize(stations, Seen::default());
                let seen = &mut by_station[stop.station];
                seen.readings += 1;
                if seen_steps.insert((stop.step, target, stop.station)) {
                    seen.steps += 1;
                }
            }
        }
        let covered = found.into_iter().map(|((run, target), seen)| Coverage {
            run,
            target,
            steps_of_run: steps_of_run[run],
            seen,
        });
        covered.collect()
    }
}
