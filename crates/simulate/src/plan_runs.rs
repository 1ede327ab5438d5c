//! The runs of a scenario: which positions, targets and directions.

use trueaxis_campaign::{AxisSpec, Direction, Target};
use trueaxis_files::{DocumentProblem, index_of};
use trueaxis_kinematics::{Axis, Machine};

use crate::check;
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
    targets: &[Target],
) -> Result<Vec<PlannedRun>, Error> {
    let names: Vec<&str> = scenario.runs.iter().map(|run| run.name.as_str()).collect();
    check::distinct_names("runs", "run", &names)?;
    let specs = scenario.runs.iter().enumerate();
    let runs = specs
        .map(|(i, spec)| {
            let run = RunPlan {
                field: format!("runs[{i}]"),
                spec,
                scenario,
                machine,
                axes: machine.axes().iter().map(Axis::name).collect(),
            };
            run.plan(targets)
        })
        .collect::<Result<Vec<_>, _>>()?;
    for (i, target) in targets.iter().enumerate() {
        if target.carrier.is_some() && !runs.iter().any(|run| run.targets.contains(&i)) {
            return Err(Problem::TargetUnused {
                target: target.name.clone(),
            }
            .at(format!("targets[{i}]")));
        }
    }
    Ok(runs)
}

/// One run of the scenario, and what it refers to.
struct RunPlan<'a> {
    field: String,
    spec: &'a RunSpec,
    scenario: &'a Scenario,
    machine: &'a Machine,
    /// Names of the axes.
    axes: Vec<&'a str>,
}

impl RunPlan<'_> {
    fn plan(&self, targets: &[Target]) -> Result<PlannedRun, Error> {
        let field = format!("{}.axis", self.field);
        let axis = index_of(field, "axis", &self.spec.axis, &self.axes)?;
        Ok(PlannedRun {
            name: self.spec.name.clone(),
            axis,
            positions: self.positions(axis)?,
            parked: self.parked(axis)?,
            targets: self.measured_targets(axis, targets)?,
            directions: self.directions()?,
        })
    }

    /// Commanded positions of the run's axis, mm or rad.
    fn positions(&self, axis: usize) -> Result<Vec<f64>, Error> {
        let (field, positions) = match (&self.spec.positions, &self.spec.sweep) {
            (Some(positions), None) => (format!("{}.positions", self.field), positions.clone()),
            (None, Some(sweep)) => {
                let field = format!("{}.sweep", self.field);
                let positions = sweep_positions(&field, sweep)?;
                (field, positions)
            }
            _ => {
                let expected = "either `positions` or `sweep`";
                return Err(check::expected(&self.field, expected));
            }
        };
        if positions.is_empty() {
            return Err(check::expected(field, "at least one position"));
        }
        check::increasing(&field, &positions)?;
        let positions = positions.iter();
        positions
            .map(|&q| self.reachable(&field, q, axis))
            .collect()
    }

    /// Positions of all axes beside the run's, mm or rad.
    fn parked(&self, axis: usize) -> Result<Vec<f64>, Error> {
        let mut positions = vec![0.0; self.axes.len()];
        for (name, &position) in &self.spec.parked {
            let field = format!("{}.parked.{name}", self.field);
            let index = index_of(&field, "axis", name, &self.axes)?;
            if index == axis {
                return Err(check::expected(field, "another axis than the run moves"));
            }
            check::finite(&field, &[position])?;
            positions[index] = self.reachable(&field, position, index)?;
        }
        Ok(positions)
    }

    /// The position in mm or rad if the axis gets there.
    fn reachable(&self, field: &str, position: f64, axis: usize) -> Result<f64, Error> {
        let AxisSpec { name, travel, .. } = &self.scenario.machine.axes[axis];
        let [low, high] = *travel;
        if position < low || position > high {
            let axis = name.clone();
            let problem = Problem::OutsideTravel {
                axis,
                position,
                low,
                high,
            };
            return Err(problem.at(field));
        }
        let kind = self.machine.axes()[axis].kind();
        Ok(kind.position_from_file(position))
    }

    fn measured_targets(&self, axis: usize, targets: &[Target]) -> Result<Vec<usize>, Error> {
        let moves = |target: usize| {
            let chain = self.machine.chain(targets[target].carrier);
            chain.contains(&axis)
        };
        let Some(listed) = &self.spec.targets else {
            let moved: Vec<usize> = (0..targets.len()).filter(|&i| moves(i)).collect();
            if moved.is_empty() {
                let expected = format!("a target that axis {} moves", self.spec.axis);
                return Err(check::expected(&self.field, expected));
            }
            return Ok(moved);
        };
        let list = format!("{}.targets", self.field);
        if listed.is_empty() {
            return Err(check::expected(list, "at least one target"));
        }
        let names: Vec<&str> = targets.iter().map(|target| target.name.as_str()).collect();
        let mut measured = Vec::with_capacity(listed.len());
        for (i, name) in listed.iter().enumerate() {
            let field = format!("{list}[{i}]");
            let index = index_of(&field, "target", name, &names)?;
            if let Some(first) = measured.iter().position(|&other| other == index) {
                let problem = DocumentProblem::DuplicateName {
                    what: "target",
                    name: name.clone(),
                    first: format!("{list}[{first}]"),
                };
                return Err(problem.in_field(field).into());
            }
            if !moves(index) {
                let problem = Problem::TargetAtRest {
                    axis: self.spec.axis.clone(),
                    target: name.clone(),
                    carrier: targets[index]
                        .carrier
                        .map_or("the bed", |axis| self.axes[axis])
                        .to_owned(),
                };
                return Err(problem.at(field));
            }
            measured.push(index);
        }
        Ok(measured)
    }

    fn directions(&self) -> Result<Vec<Direction>, Error> {
        match self.spec.directions.as_slice() {
            [1] => Ok(vec![Direction::Forward]),
            [-1] => Ok(vec![Direction::Backward]),
            [1, -1] => Ok(vec![Direction::Forward, Direction::Backward]),
            [-1, 1] => Ok(vec![Direction::Backward, Direction::Forward]),
            _ => {
                let field = format!("{}.directions", self.field);
                Err(check::expected(field, "[1], [-1], [1, -1] or [-1, 1]"))
            }
        }
    }
}

/// More positions than any axis is measured at; a step this small is a mistake.
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
