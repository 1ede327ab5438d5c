//! The order and the times of the readings.
//!
//! Stations one after another; within the occupation of a station repeats, runs, sweeps, positions,
//! targets.

use trueaxis_campaign::Step;

use super::Kind;
use super::layout::{Layout, Sweep};

/// From one reading to the next at the same stop, s.
const PER_READING_S: f64 = 2.0;
/// For a move to the next stop, s.
const PER_MOVE_S: f64 = 4.0;
/// For carrying the tracker to the next station, s.
const PER_STATION_CHANGE_S: f64 = 900.0;
/// On the fly: from one position to the next, s.
const ON_THE_FLY_S: f64 = 2.0;

/// All visits in measuring order.
pub(super) struct Schedule {
    pub(super) steps: Vec<Step>,
    pub(super) visits: Vec<Visit>,
    /// First and last reading of each station, s.
    pub(super) occupations_s: Vec<[f64; 2]>,
}

/// One visit of the machine to a step.
#[derive(Debug, Clone)]
pub(super) struct Visit {
    pub(super) station: usize,
    /// From 1.
    pub(super) repeat: u32,
    pub(super) step: usize,
    /// +1 or -1.
    pub(super) direction: f64,
    /// With sign, mm/s or rad/s; 0 where the machine stands still.
    pub(super) speed_per_s: f64,
    /// Targets and times of the readings, s.
    pub(super) readings: Vec<(usize, f64)>,
}

impl Schedule {
    pub(super) fn new(kind: &Kind, layout: &Layout) -> Self {
        let mut schedule = Self {
            steps: steps(layout),
            visits: Vec::new(),
            occupations_s: Vec::new(),
        };
        let directions = if kind.both_directions {
            [1.0, -1.0].as_slice()
        } else {
            &[1.0]
        };
        let mut now_s = 0.0;
        let of_repeat = layout.sweeps.len() * if kind.on_the_fly { 1 } else { directions.len() };
        let sweeps = of_repeat * kind.repeats as usize;
        // Nearly even, from before the first to after the last.
        let is_bed_read = |sweep: usize| {
            let between = kind.bed_readings.saturating_sub(1).max(1);
            (0..kind.bed_readings).any(|i| (i * sweeps).div_ceil(between) == sweep)
        };
        for station in 0..kind.stations {
            let first = schedule.visits.len();
            let mut sweep_of_occupation = 0;
            for repeat in 1..=kind.repeats {
                let mut first_step = 0;
                for sweep in &layout.sweeps {
                    if is_bed_read(sweep_of_occupation) {
                        schedule.bed(layout, (station, repeat), &mut now_s);
                    }
                    sweep_of_occupation += sweeps / (layout.sweeps.len() * kind.repeats as usize);
                    let run = Run {
                        station,
                        repeat,
                        first_step,
                    };
                    if kind.on_the_fly {
                        schedule.on_the_fly(&run, sweep, directions, &mut now_s);
                    } else {
                        schedule.stop_and_go(&run, sweep, directions, &mut now_s);
                    }
                    first_step += sweep.positions.len();
                }
            }
            if is_bed_read(sweep_of_occupation) {
                schedule.bed(layout, (station, kind.repeats), &mut now_s);
            }
            let times = schedule.visits[first..].iter().flat_map(|v| &v.readings);
            let (mut from_s, mut to_s) = (f64::INFINITY, f64::NEG_INFINITY);
            times.for_each(|&(_, t)| (from_s, to_s) = (from_s.min(t), to_s.max(t)));
            schedule.occupations_s.push([from_s, to_s]);
            now_s += PER_STATION_CHANGE_S;
        }
        schedule
    }

    /// First and last reading of all, s.
    pub(super) fn span_s(&self) -> [f64; 2] {
        [
            self.occupations_s
                .first()
                .map_or(0.0, |occupation| occupation[0]),
            self.occupations_s
                .last()
                .map_or(0.0, |occupation| occupation[1]),
        ]
    }

    /// Whether targets on the bed are read.
    pub(super) fn is_of_bed(&self, visit: &Visit) -> bool {
        self.steps[visit.step].run.is_none()
    }

    /// Number of readings.
    pub(super) fn readings(&self) -> usize {
        self.visits.iter().map(|visit| visit.readings.len()).sum()
    }

    /// The targets on the bed, where the machine stands.
    fn bed(&mut self, layout: &Layout, (station, repeat): (usize, u32), now_s: &mut f64) {
        let stands = self.visits.last().map_or(0, |visit| visit.step);
        let positions = self.steps[stands].positions.clone();
        let is_it = |step: &Step| step.run.is_none() && step.positions == positions;
        let step = self.steps.iter().position(is_it).unwrap_or_else(|| {
            let run = None;
            self.steps.push(Step { run, positions });
            self.steps.len() - 1
        });
        *now_s += PER_MOVE_S;
        let readings = layout.on_bed().into_iter().map(|target| {
            let time_s = *now_s;
            *now_s += PER_READING_S;
            (target, time_s)
        });
        self.visits.push(Visit {
            station,
            repeat,
            step,
            direction: 1.0,
            speed_per_s: 0.0,
            readings: readings.collect(),
        });
    }

    /// One run at standstill: there, and back if both sides are wanted.
    fn stop_and_go(&mut self, run: &Run, sweep: &Sweep, directions: &[f64], now_s: &mut f64) {
        for &direction in directions {
            for step in run.order(sweep, direction) {
                *now_s += PER_MOVE_S;
                let readings = sweep.targets.iter().map(|&target| {
                    let time_s = *now_s;
                    *now_s += PER_READING_S;
                    (target, time_s)
                });
                let readings = readings.collect();
                self.visits.push(run.visit(step, direction, readings));
            }
        }
    }

    /// One run at constant feed: there and back for one target after another.
    fn on_the_fly(&mut self, run: &Run, sweep: &Sweep, directions: &[f64], now_s: &mut f64) {
        let feed_per_s = (sweep.positions[1] - sweep.positions[0]) / ON_THE_FLY_S;
        for &target in &sweep.targets {
            for &direction in directions {
                *now_s += PER_MOVE_S;
                for step in run.order(sweep, direction) {
                    let visit = run.visit(step, direction, vec![(target, *now_s)]);
                    self.visits.push(Visit {
                        speed_per_s: direction * feed_per_s,
                        ..visit
                    });
                    *now_s += ON_THE_FLY_S;
                }
            }
        }
    }
}

/// One run within a repeat at a station.
struct Run {
    station: usize,
    repeat: u32,
    first_step: usize,
}

impl Run {
    /// The steps of the run in the order of a sweep.
    fn order(&self, sweep: &Sweep, direction: f64) -> Vec<usize> {
        let up = self.first_step..self.first_step + sweep.positions.len();
        if direction > 0.0 {
            up.collect()
        } else {
            up.rev().collect()
        }
    }

    fn visit(&self, step: usize, direction: f64, readings: Vec<(usize, f64)>) -> Visit {
        Visit {
            station: self.station,
            repeat: self.repeat,
            step,
            direction,
            speed_per_s: 0.0,
            readings,
        }
    }
}

/// Steps of all runs, along the first sweep.
fn steps(layout: &Layout) -> Vec<Step> {
    let axes = layout.machine.axes().len();
    let sweeps = layout.sweeps.iter().enumerate();
    let steps = sweeps.flat_map(|(run, sweep)| {
        sweep.positions.iter().map(move |&position| {
            let mut positions = vec![0.0; axes];
            positions[sweep.axis] = position;
            let run = Some(run);
            Step { run, positions }
        })
    });
    steps.collect()
}
