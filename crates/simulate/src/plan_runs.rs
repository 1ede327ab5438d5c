//! The runs of a scenario: which positions, targets and directions.

use trueaxis_campaign::{AxisSpec, Direction};
use trueaxis_files::{DocumentProblem, index_of};
use trueaxis_kinematics::{Axis, Machine};

use crate::axis_unit;
use crate::check;
use crate::plan::PlannedTarget;
use crate::{Error, Problem, RunSpec, Scenario, Sweep};

/// A run with its commanded positions in mm or rad.
pub(crate) struct PlannedRun {
    pub(crate) name: String,
    pub(crate) axis: usize,
    /// Commanded positions of the axis, increasing.
    pub(crate) positions: Vec<f64>,
    /// Positions of all axes; that of the run's axis is replaced at each step.
    pub(crate) parked: Vec<f64>,
    /// Targets measured at each stop, in order.
    pub(crate) targets: Vec<usize>,
    /// Sweeps, in order.
    pub(crate) directions: Vec<Direction>,
}

pub(crate) fn plan_runs(
    scenario: &Scenario,
    machine: &Machine,
    targets: &[PlannedTarget],
) -> Result<Vec<PlannedRun>, Error> {
    let names: Vec<&str> = scenario.runs.iter().map(|run| run.name.as_str()).collect();
    check::distinct_names("runs", "run", &names)?;
    let specs = scenario.runs.iter().enumerate();
    let runs = specs
        .map(|(i, spec)| plan_run(&format!("runs[{i}]"), spec, scenario, machine, targets))
        .collect::<Result<Vec<_>, _>>()?;
    for (i, target) in targets.iter().enumerate() {
        if !runs.iter().any(|run| run.targets.contains(&i)) {
            return Err(Problem::TargetUnused {
                target: target.name.clone(),
            }
            .at(format!("targets[{i}]")));
        }
    }
    Ok(runs)
}

fn plan_run(
    field: &str,
    spec: &RunSpec,
    scenario: &Scenario,
    machine: &Machine,
    targets: &[PlannedTarget],
) -> Result<PlannedRun, Error> {
    let names: Vec<&str> = machine.axes().iter().map(Axis::name).collect();
    let axis = index_of(format!("{field}.axis"), "axis", &spec.axis, &names)?;
    Ok(PlannedRun {
        name: spec.name.clone(),
        axis,
        positions: positions(field, spec, axis, scenario, machine)?,
        parked: parked(field, spec, axis, scenario, machine)?,
        targets: measured_targets(field, spec, axis, machine, targets)?,
        directions: directions(field, spec)?,
    })
}

/// Commanded positions of the run's axis, mm or rad.
fn positions(
    field: &str,
    spec: &RunSpec,
    axis: usize,
    scenario: &Scenario,
    machine: &Machine,
) -> Result<Vec<f64>, Error> {
    let (field, positions) = match (&spec.positions, &spec.sweep) {
        (Some(positions), None) => (format!("{field}.positions"), positions.clone()),
        (None, Some(sweep)) => {
            let field = format!("{field}.sweep");
            let positions = sweep_positions(&field, sweep)?;
            (field, positions)
        }
        _ => return Err(check::expected(field, "either `positions` or `sweep`")),
    };
    if positions.is_empty() {
        return Err(check::expected(field, "at least one position"));
    }
    check::increasing(&field, &positions)?;
    positions
        .iter()
        .map(|&q| reachable(&field, q, axis, scenario, machine))
        .collect()
}

/// More positions than any axis is measured at; a step this small is a slip.
const MOST_POSITIONS: u32 = 100_000;

/// Positions are rounded to this many per mm or deg, so that `3 · 0.1` is `0.3`.
const POSITION_GRID: f64 = 1e9;

fn sweep_positions(field: &str, sweep: &Sweep) -> Result<Vec<f64>, Error> {
    let Sweep { start, stop, step } = *sweep;
    check::finite(field, &[start, stop])?;
    check::positive(&format!("{field}.step"), step)?;
    let on_grid = |q: f64| (q * POSITION_GRID).round() / POSITION_GRID;
    let positions: Vec<f64> = (0..MOST_POSITIONS)
        .map(|i| on_grid(start + step * f64::from(i)))
        .take_while(|&q| q <= on_grid(stop))
        .collect();
    let reached = positions.last().map(|q| q.total_cmp(&on_grid(stop)));
    if reached.is_none_or(|order| order.is_ne()) {
        let steps = format!("whole steps from start to stop, but {step} does not divide");
        let expected = format!("{steps} {start} to {stop} into at most {MOST_POSITIONS}");
        return Err(check::expected(field, expected));
    }
    Ok(positions)
}

/// Positions of all axes beside the run's, mm or rad.
fn parked(
    field: &str,
    spec: &RunSpec,
    axis: usize,
    scenario: &Scenario,
    machine: &Machine,
) -> Result<Vec<f64>, Error> {
    let names: Vec<&str> = machine.axes().iter().map(Axis::name).collect();
    let mut positions = vec![0.0; names.len()];
    for (name, &position) in &spec.parked {
        let field = format!("{field}.parked.{name}");
        let index = index_of(&field, "axis", name, &names)?;
        if index == axis {
            return Err(check::expected(field, "another axis than the run moves"));
        }
        check::finite(&field, &[position])?;
        let reached = reachable(&field, position, index, scenario, machine)?;
        if let Some(slot) = positions.get_mut(index) {
            *slot = reached;
        }
    }
    Ok(positions)
}

/// The position in mm or rad if the axis gets there.
fn reachable(
    field: &str,
    position: f64,
    axis: usize,
    scenario: &Scenario,
    machine: &Machine,
) -> Result<f64, Error> {
    let specs = scenario
        .machine
        .axes
        .get(axis)
        .zip(machine.axes().get(axis));
    let Some((AxisSpec { name, travel, .. }, axis)) = specs else {
        return Ok(position);
    };
    let [low, high] = *travel;
    if position < low || position > high {
        return Err(Problem::OutsideTravel {
            axis: name.clone(),
            position,
            low,
            high,
        }
        .at(field));
    }
    Ok(axis_unit::from_file(axis.kind(), position))
}

fn measured_targets(
    field: &str,
    spec: &RunSpec,
    axis: usize,
    machine: &Machine,
    targets: &[PlannedTarget],
) -> Result<Vec<usize>, Error> {
    let moves = |target: &PlannedTarget| machine.chain(target.carrier).contains(&axis);
    let Some(listed) = &spec.targets else {
        let all = targets.iter().enumerate();
        let moved: Vec<usize> = all.filter(|(_, t)| moves(t)).map(|(i, _)| i).collect();
        if moved.is_empty() {
            let expected = format!("a target that axis {} moves", spec.axis);
            return Err(check::expected(field, expected));
        }
        return Ok(moved);
    };
    let list = format!("{field}.targets");
    if listed.is_empty() {
        return Err(check::expected(list, "at least one target"));
    }
    let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
    let mut measured = Vec::with_capacity(listed.len());
    for (i, name) in listed.iter().enumerate() {
        let field = format!("{list}[{i}]");
        let index = index_of(&field, "target", name, &names)?;
        if measured.contains(&index) {
            let first = measured.iter().position(|&other| other == index);
            let problem = DocumentProblem::DuplicateName {
                what: "target",
                name: name.clone(),
                first: format!("{list}[{}]", first.unwrap_or_default()),
            };
            return Err(problem.in_field(field).into());
        }
        if let Some(target) = targets.get(index).filter(|&target| !moves(target)) {
            let carrier = machine.axes().get(target.carrier).map(Axis::name);
            return Err(Problem::TargetAtRest {
                axis: spec.axis.clone(),
                target: name.clone(),
                carrier: carrier.unwrap_or_default().to_owned(),
            }
            .at(field));
        }
        measured.push(index);
    }
    Ok(measured)
}

fn directions(field: &str, spec: &RunSpec) -> Result<Vec<Direction>, Error> {
    match spec.directions.as_slice() {
        [1] => Ok(vec![Direction::Forward]),
        [-1] => Ok(vec![Direction::Backward]),
        [1, -1] => Ok(vec![Direction::Forward, Direction::Backward]),
        [-1, 1] => Ok(vec![Direction::Backward, Direction::Forward]),
        _ => Err(check::expected(
            format!("{field}.directions"),
            "[1], [-1], [1, -1] or [-1, 1]",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_hits_its_decimal_positions() {
        let (start, stop, step) = (0.1, 0.7, 0.1);
        let positions = sweep_positions("sweep", &Sweep { start, stop, step }).unwrap();
        assert_eq!(positions, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]);
    }

    #[test]
    fn a_sweep_must_end_on_a_step() {
        for (start, stop, step) in [(0.0, 45.0, 20.0), (10.0, 0.0, 5.0), (0.0, 1.0, 1e-8)] {
            let refused = sweep_positions("sweep", &Sweep { start, stop, step });
            let problem = refused.unwrap_err().problem;
            assert!(matches!(*problem, Problem::Expected { .. }));
        }
        let (start, stop, step) = (0.0, 10.0, 0.0);
        let refused = sweep_positions("sweep", &Sweep { start, stop, step });
        let problem = refused.unwrap_err().problem;
        assert!(matches!(*problem, Problem::Value { .. }));
    }
}
