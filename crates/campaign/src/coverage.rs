//! Which target was read from which station in which run, and where it was not.

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
        let targets = self.targets.len();
        let mut seen = vec![Seen::default(); self.runs.len() * targets * stations];
        let mut step_seen = vec![false; self.steps.len() * targets * stations];
        for stop in stops {
            let run = self.steps[stop.step].run;
            for reading in readings_of(stop, readings) {
                let place =
                    |row: usize| (row * targets + reading.target()) * stations + stop.station;
                let seen = &mut seen[place(run)];
                seen.readings += 1;
                if !std::mem::replace(&mut step_seen[place(stop.step)], true) {
                    seen.steps += 1;
                }
            }
        }
        let rows = seen.chunks(stations.max(1)).enumerate();
        let covered = rows.map(|(row, seen)| Coverage {
            run: row / targets,
            target: row % targets,
            steps_of_run: steps_of_run[row / targets],
            seen: seen.to_vec(),
        });
        let is_measured = |covered: &Coverage| covered.seen.iter().any(|seen| seen.readings > 0);
        covered.filter(is_measured).collect()
    }
}
