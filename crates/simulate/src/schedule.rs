//! The order and the times of a campaign: which step is visited when.

use trueaxis_campaign::{Direction, Step};

use crate::plan::{Plan, PlannedRun};
use crate::{Scenario, Timing};

/// One visit of the machine to a step, or of the tracker to the bed.
pub(crate) struct Visit<'a> {
    pub(crate) station: usize,
    /// From 1.
    pub(crate) repeat: u32,
    /// None at the bed.
    pub(crate) run: Option<&'a PlannedRun>,
    /// Targets that are read, in order.
    pub(crate) targets: &'a [usize],
    pub(crate) direction: Direction,
    /// Index of the step.
    pub(crate) step: usize,
    /// Time of each reading, s.
    pub(crate) times_s: Vec<f64>,
}

/// The steps of all runs in the order of their sweeps.
fn steps_of_runs(plan: &Plan) -> Vec<Step> {
    let runs = plan.runs.iter().enumerate();
    let steps = runs.flat_map(|(run, planned)| {
        let mut swept = planned.positions.clone();
        if planned.directions.first() == Some(&Direction::Backward) {
            swept.reverse();
        }
        swept.into_iter().map(move |position| {
            let mut positions = planned.parked.clone();
            positions[planned.axis] = position;
            let run = Some(run);
            Step { run, positions }
        })
    });
    steps.collect()
}

/// All steps as they first appear, and all visits in measuring order: stations, repeats, runs, directions,
/// positions.
pub(crate) fn schedule<'a>(scenario: &Scenario, plan: &'a Plan) -> (Vec<Step>, Vec<Visit<'a>>) {
    let mut steps = steps_of_runs(plan);
    let mut visits = visits(scenario, plan, &mut steps);
    // As they first appear: those of the bed are among those of the runs.
    let mut number = vec![None; steps.len()];
    let mut in_order = Vec::with_capacity(steps.len());
    for visit in &mut visits {
        let step = *number[visit.step].get_or_insert_with(|| {
            in_order.push(steps[visit.step].clone());
            in_order.len() - 1
        });
        visit.step = step;
    }
    (in_order, visits)
}

/// The visits; `steps` are those of the runs, to which those of the bed are added.
fn visits<'a>(scenario: &Scenario, plan: &'a Plan, steps: &mut Vec<Step>) -> Vec<Visit<'a>> {
    let timing = scenario.timing;
    let mut clock = Clock {
        now_s: timing.start_s,
        timing,
    };
    let mut visits: Vec<Visit<'_>> = Vec::new();
    for station in 0..scenario.stations.len() {
        if station > 0 {
            clock.now_s += timing.per_station_change_s;
        }
        let mut sweep = 0;
        for repeat in 1..=scenario.repeats {
            let mut first_step = 0;
            for run in &plan.runs {
                let step_count = run.positions.len();
                for &direction in &run.directions {
                    if plan.bed.is_read_before(sweep) {
                        // The machine stands where it came to last; at first, where it will begin.
                        let stands = visits.last().map_or(first_step, |visit| visit.step);
                        visits.push(bed(plan, steps, (station, repeat, stands), &mut clock));
                    }
                    sweep += 1;
                    // Steps are numbered along the first sweep; a second one runs back.
                    let returns = run.directions.first() != Some(&direction);
                    visits.extend((0..step_count).map(|i| Visit {
                        station,
                        repeat,
                        run: Some(run),
                        targets: &run.targets,
                        direction,
                        step: first_step + if returns { step_count - 1 - i } else { i },
                        times_s: clock.stop(run.targets.len()),
                    }));
                }
                first_step += step_count;
            }
        }
        if plan.bed.is_read_before(sweep) {
            let stands = visits.last().map_or(0, |visit| visit.step);
            let last = (station, scenario.repeats, stands);
            visits.push(bed(plan, steps, last, &mut clock));
        }
    }
    visits
}

/// The targets on the bed are read while the machine stands at a step.
fn bed<'a>(
    plan: &'a Plan,
    steps: &mut Vec<Step>,
    (station, repeat, stands): (usize, u32, usize),
    clock: &mut Clock,
) -> Visit<'a> {
    let positions = steps[stands].positions.clone();
    let known = steps
        .iter()
        .position(|s| s.run.is_none() && s.positions == positions);
    let step = known.unwrap_or_else(|| {
        let run = None;
        steps.push(Step { run, positions });
        steps.len() - 1
    });
    Visit {
        station,
        repeat,
        run: None,
        targets: &plan.bed.targets,
        direction: Direction::Forward,
        step,
        times_s: clock.stop(plan.bed.targets.len()),
    }
}

/// Times are given in ms.
const TIMES_PER_S: f64 = 1e3;

struct Clock {
    now_s: f64,
    timing: Timing,
}

impl Clock {
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
