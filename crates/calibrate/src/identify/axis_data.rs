//! What was measured of one axis: its runs, records and nodes.

use nalgebra::Point3;
use trueaxis_campaign::{Campaign, Direction};
use trueaxis_kinematics::{AxisKind, Machine};
use trueaxis_poses::{PoseObservation, Poses, step_in_words};

use crate::Error;
use crate::result::interpolation::{Place, sides_of, weights_at};

/// All measurements of one axis.
#[derive(Default)]
pub(crate) struct AxisData {
    pub(crate) axis: usize,
    /// Campaign runs of the axis.
    pub(crate) runs: Vec<RunData>,
    /// One for each step of each run (and each side of approach, where kept apart).
    pub(crate) records: Vec<Record>,
    /// The different positions, ascending, backward before forward.
    pub(crate) nodes: Vec<Node>,
    /// The sides of approach that the nodes have.
    pub(crate) sides: Vec<Option<Direction>>,
}

pub(crate) struct RunData {
    pub(crate) run: usize,
    /// The body that the axis moves in this run.
    pub(crate) body: usize,
    /// Its targets, and the carrier of each.
    pub(crate) targets: Vec<usize>,
    carriers: Vec<usize>,
    /// The carrier farthest from the bed, with which the body moves.
    carrier: usize,
    /// Where all axes stand at its first step; the others stand still.
    pub(crate) positions: Vec<f64>,
}

pub(crate) struct Record {
    /// Index into [`AxisData::runs`].
    pub(crate) run: usize,
    /// Index of the measured pose.
    pub(crate) pose: usize,
    /// Index into [`AxisData::nodes`].
    pub(crate) node: usize,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    /// mm or rad.
    pub(crate) position: f64,
    /// Side of approach, where kept apart.
    pub(crate) direction: Option<Direction>,
    /// Its records, in the order of measuring.
    pub(crate) records: Vec<usize>,
}

/// A rotary axis this close to home is at home, rad.
const HOME_TOL_RAD: f64 = 1e-9;

/// Sorts the measured poses by the axis under test.
pub(crate) fn by_axis(campaign: &Campaign, poses: &Poses) -> Result<Vec<AxisData>, Error> {
    let mut all: Vec<AxisData> = Vec::new();
    for (pose, observation) in poses.observations.iter().enumerate() {
        let step = &campaign.steps[observation.step];
        let axis = campaign.runs[step.run].axis;
        let place = all.iter().position(|data| data.axis == axis);
        let place = place.unwrap_or_else(|| {
            all.push(AxisData {
                axis,
                ..AxisData::default()
            });
            all.len() - 1
        });
        let data = &mut all[place];
        let run = data.runs.iter().position(|r| r.run == step.run);
        let run = run.unwrap_or_else(|| {
            data.runs.push(RunData::new(campaign, poses, observation));
            data.runs.len() - 1
        });
        data.records.push(Record { run, pose, node: 0 });
    }
    for data in &mut all {
        number_nodes(data, campaign, poses);
        check_other_axes(data, campaign, poses)?;
    }
    // In the order of the machine's axes, whatever the order of measuring.
    all.sort_by_key(|data| data.axis);
    Ok(all)
}

/// Other axes of the chain must stand still during a run, and rotary ones at home: their errors
/// would enter those of the axis under test, or turn them.
fn check_other_axes(data: &AxisData, campaign: &Campaign, poses: &Poses) -> Result<(), Error> {
    let machine = &campaign.machine;
    for record in &data.records {
        let content = &data.runs[record.run];
        let step = poses.observations[record.pose].step;
        let (positions, first) = (&campaign.steps[step].positions, &content.positions);
        for &other in content.carriers.iter().flat_map(|&c| machine.chain(c)) {
            if other == data.axis {
                continue;
            }
            let run = campaign.runs[content.run].name.clone();
            let other_name = machine.axes()[other].name().to_owned();
            if positions[other].total_cmp(&first[other]).is_ne() {
                return Err(Error::SeveralAxesMove {
                    run,
                    axis: machine.axes()[data.axis].name().to_owned(),
                    other: other_name,
                    step: step_in_words(campaign, step),
                });
            }
            let rotary = machine.axes()[other].kind() == AxisKind::Rotary;
            if rotary && first[other].abs() > HOME_TOL_RAD {
                return Err(Error::NotIdentifiable {
                    what: format!(
                        "run {run}: rotary axis {other_name} stands at {:.4}° instead of home",
                        first[other].to_degrees()
                    ),
                    mend: format!("measure this run with {other_name} at 0°"),
                });
            }
        }
    }
    Ok(())
}

fn number_nodes(data: &mut AxisData, campaign: &Campaign, poses: &Poses) {
    let node_of = |record: &Record| {
        let observation = &poses.observations[record.pose];
        Node {
            position: campaign.steps[observation.step].positions[data.axis],
            direction: observation.direction,
            records: Vec::new(),
        }
    };
    let order = |a: &Node, b: &Node| {
        let by_position = a.position.total_cmp(&b.position);
        by_position.then(a.direction.cmp(&b.direction))
    };
    let own: Vec<Node> = data.records.iter().map(node_of).collect();
    let mut nodes = own.clone();
    nodes.sort_by(order);
    nodes.dedup_by(|a, b| order(a, b).is_eq());
    for (i, (record, own)) in data.records.iter_mut().zip(&own).enumerate() {
        record.node = nodes.partition_point(|node| order(node, own).is_lt());
        nodes[record.node].records.push(i);
    }
    data.sides = sides_of(&nodes);
    data.nodes = nodes;
}

impl Place for Node {
    fn position(&self) -> f64 {
        self.position
    }

    fn direction(&self) -> Option<Direction> {
        self.direction
    }
}

impl AxisData {
    /// Weights of the nodes whose sum is the curve at `position` ([`weights_at`]).
    pub(crate) fn weights_at(&self, position: f64) -> Vec<(usize, f64)> {
        weights_at(&self.nodes, &self.sides, position)
    }
}

impl RunData {
    /// The run of its first pose.
    fn new(campaign: &Campaign, poses: &Poses, first: &PoseObservation) -> Self {
        let step = &campaign.steps[first.step];
        let targets = poses.bodies[first.body].targets.clone();
        let carriers = targets.iter().map(|&t| campaign.targets[t].carrier);
        let depth = |&carrier: &usize| campaign.machine.chain(carrier).len();
        let carrier = carriers.clone().max_by_key(depth);
        Self {
            run: step.run,
            body: first.body,
            carrier: carrier.unwrap_or(campaign.runs[step.run].axis),
            carriers: carriers.collect(),
            targets,
            positions: step.positions.clone(),
        }
    }

    /// The axes outside `axis`, between it and the bed, and those inside it, between it and the body.
    pub(crate) fn around<'a>(
        &self,
        machine: &'a Machine,
        axis: usize,
    ) -> (&'a [usize], &'a [usize]) {
        around(machine, self.carrier, axis)
    }

    /// The axes inside `axis`, between it and a target.
    pub(crate) fn inside<'a>(
        &self,
        machine: &'a Machine,
        axis: usize,
        place: usize,
    ) -> &'a [usize] {
        around(machine, self.carriers[place], axis).1
    }

    /// Nominal positions of the targets at home, mm.
    pub(crate) fn nominal_mm(&self, campaign: &Campaign) -> Vec<Point3<f64>> {
        let home = |&target: &usize| campaign.targets[target].home_mm;
        self.targets.iter().map(home).collect()
    }
}

/// The axes before and after `axis` in the chain of a carrier.
fn around(machine: &Machine, carrier: usize, axis: usize) -> (&[usize], &[usize]) {
    let chain = machine.chain(carrier);
    let place = chain.iter().position(|&a| a == axis).unwrap_or(0);
    (&chain[..place], &chain[place + 1..])
}
