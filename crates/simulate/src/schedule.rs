//! The order and the times of a campaign: which step is visited when.

use trueaxis_campaign::{Direction, Step};

use crate::plan::{Plan, PlannedRun};
use crate::{Scenario, Timing};

/// One visit of the machine to a step.
pub(crate) struct Visit<'a> {
    pub(crate) station: usize,
    /// From 1.
    pub(crate) repeat: u32,
    pub(crate) run: &'a PlannedRun,
    pub(crate) direction: Direction,
    /// Index of the step.
    pub(crate) step: usize,
    /// Time of each reading, s.
    pub(crate) times_s: Vec<f64>,
}

/// The steps of all runs in the order of their first visit.
pub(crate) fn steps(plan: &Plan) -> Vec<Step> {
    let runs = plan.runs.iter().enumerate();
    let steps = runs.flat_map(|(run, planned)| {
        let mut swept = planned.positions.clone();
        if planned.directions.first() == Some(&Direction::Backward) {
            swept.reverse();
        }
        swept.into_iter().map(move |position| {
            let mut positions = planned.parked.clone();
            positions[planned.axis] = position;
            Step { run, positions }
        })
    });
    steps.collect()
}

/// All visits in measuring order: stations, repeats, runs, directions, positions.
pub(crate) fn visits<'a>(scenario: &Scenario, plan: &'a Plan) -> Vec<Visit<'a>> {
    let mut clock = Clock::new(scenario.timing);
    let mut visits = Vec::new();
    for station in 0..scenario.stations.len() {
        if station > 0 {
            clock.carry_tracker();
        }
        for repeat in 1..=scenario.repeats {
            let mut first_step = 0;
            for run in &plan.runs {
                let step_count = run.positions.len();
                for &direction in &run.directions {
                    // Steps are numbered along the first sweep; a second one runs back.
                    let returns = run.directions.first() != Some(&direction);
                    visits.extend((0..step_count).map(|i| Visit {
                        station,
                        repeat,
                        run,
                        direction,
                        step: first_step + if returns { step_count - 1 - i } else { i },
                        times_s: clock.stop(run.targets.len()),
                    }));
                }
                first_step += step_count;
            }
        }
    }
    visits
}

/// Times are given in ms.
const TIMES_PER_S: f64 = 1e3;

struct Clock {
    now_s: f64,
    timing: Timing,
}

impl Clock {
    fn new(timing: Timing) -> Self {
        Self {
            now_s: timing.start_s,
            timing,
        }
    }

    fn carry_tracker(&mut self) {
        self.now_s += self.timing.per_station_change_s;
    }

    /// Moves to a stop and takes the readings there.
    fn stop(&mut self, readings: usize) -> Vec<f64> {
        self.now_s += self.timing.per_move_s;
        let times = (0..readings).map(|_| {
            let time_s = (self.now_s * TIMES_PER_S).round() / TIMES_PER_S;
            self.now_s += self.timing.per_reading_s;
            time_s
        });
        times.collect()
    }
}
