//! Which target was read from which station in which run, and where it was not.

use crate::{Campaign, Sighting};

/// How often a target was read in a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coverage {
    /// The run; none for targets on the bed.
    pub run: Option<usize>,
    /// The target.
    pub target: usize,
    /// Steps of the run; for targets on the bed one, to which all readings belong.
    pub steps_of_run: usize,
    /// From each station in the order of the campaign; a single entry in a points campaign.
    pub seen: Vec<Seen>,
}

/// What was read of a target in a run from one station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Seen {
    /// Readings.
    pub readings: usize,
    /// Steps with at least one reading.
    pub steps: usize,
}

/// What is missing from a station, the greatest gap first.
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
    /// What is missing from that station; nothing for one that does not exist.
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
    /// How often each target was read in each run in which any station saw it, by run and target; targets on the bed last.
    pub fn coverage(&self) -> Vec<Coverage> {
        let stations = match self.lengths {
            Some(_) => self.stations.len(),
            None => 1,
        };
        // Behind the runs is the bed.
        let bed = self.runs.len();
        let mut steps_of_run = vec![0; bed + 1];
        for run in self.steps.iter().filter_map(|step| step.run) {
            steps_of_run[run] += 1;
        }
        steps_of_run[bed] = 1;
        let targets = self.targets.len();
        let mut seen = vec![Seen::default(); (bed + 1) * targets * stations];
        let mut step_seen = vec![false; self.steps.len() * targets * stations];
        for stop in self.stops() {
            let of_stop = self.steps[stop.step].run;
            let run = of_stop.unwrap_or(bed);
            for Sighting { target, .. } in self.sightings(stop) {
                let place = |row: usize| (row * targets + target) * stations + stop.station;
                let seen = &mut seen[place(run)];
                seen.readings += 1;
                if of_stop.is_none() {
                    seen.steps = 1;
                } else if !std::mem::replace(&mut step_seen[place(stop.step)], true) {
                    seen.steps += 1;
                }
            }
        }
        let rows = seen.chunks(stations.max(1)).enumerate();
        let covered = rows.map(|(row, seen)| Coverage {
            run: Some(row / targets).filter(|&run| run < bed),
            target: row % targets,
            steps_of_run: steps_of_run[row / targets],
            seen: seen.to_vec(),
        });
        let is_measured = |covered: &Coverage| covered.seen.iter().any(|seen| seen.readings > 0);
        covered.filter(is_measured).collect()
    }
}
