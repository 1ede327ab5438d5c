//! The measurements of one axis: its runs, poses and nodes.

use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{AxisKind, Machine};
use trueaxis_poses::{PoseObservation, Poses, step_in_words};

use crate::Error;
use trueaxis_predict::{Node, weights_at};

/// All measurements of one axis.
#[derive(Default)]
pub(crate) struct AxisData {
    pub(crate) axis: usize,
    pub(crate) runs: Vec<RunData>,
    /// One for each step of each run (and each side of approach, if the sides are kept apart).
    pub(crate) poses: Vec<AxisPose>,
    /// The different positions, ascending, backward before forward.
    pub(crate) nodes: Vec<Node>,
    /// The poses of each node, in the order of measuring.
    pub(crate) poses_of: Vec<Vec<usize>>,
}

pub(crate) struct RunData {
    pub(crate) run: usize,
    /// The body that the axis moves in this run.
    pub(crate) body: usize,
    pub(crate) targets: Vec<usize>,
    /// The axes outside the one under test, between it and the bed, in the order of their chain.
    pub(crate) outer: Vec<usize>,
    /// The axes inside it, between it and the body, which moves with the carrier farthest from the bed.
    pub(crate) inner: Vec<usize>,
    /// The axes inside it, between it and each target.
    pub(crate) inside: Vec<Vec<usize>>,
    /// Positions of all axes at the first step of the run; the other axes stand still.
    pub(crate) positions: Vec<f64>,
}

pub(crate) struct AxisPose {
    /// Index into [`AxisData::runs`].
    pub(crate) run: usize,
    /// Index of the measured pose.
    pub(crate) index: usize,
    /// Index into [`AxisData::nodes`].
    pub(crate) node: usize,
    /// Its weight in the mean of its node, by the variance of the mean position of its targets; those of a node add
    /// up to one.
    pub(crate) weight: f64,
}

/// A rotary axis this close to home is at home, rad.
const HOME_TOL_RAD: f64 = 1e-9;

/// Sorts the measured poses by the axis under test.
pub(crate) fn by_axis(campaign: &Campaign, poses: &Poses) -> Result<Vec<AxisData>, Error> {
    let mut all: Vec<AxisData> = Vec::new();
    for (pose, observation) in poses.observations.iter().enumerate() {
        let step = &campaign.steps[observation.step];
        // Poses of the bed belong to no run.
        let Some(number) = step.run else { continue };
        let axis = campaign.runs[number].axis;
        let place = all.iter().position(|data| data.axis == axis);
        let place = place.unwrap_or_else(|| {
            all.push(AxisData {
                axis,
                ..AxisData::default()
            });
            all.len() - 1
        });
        let data = &mut all[place];
        let run = data.runs.iter().position(|r| r.run == number);
        let run = run.unwrap_or_else(|| {
            data.runs
                .push(RunData::new(campaign, poses, observation, number));
            data.runs.len() - 1
        });
        data.poses.push(AxisPose {
            run,
            index: pose,
            node: 0,
            weight: 1.0,
        });
    }
    for data in &mut all {
        number_nodes(data, campaign, poses);
        weigh_poses(data, poses);
        check_other_axes(data, campaign, poses)?;
    }
    // Ordered like the machine's axes, whatever the order of measuring.
    all.sort_by_key(|data| data.axis);
    Ok(all)
}

/// Other axes of the chain must stand still during a run, and rotary ones at home: otherwise their errors would enter
/// those of the axis under test, or turn them.
fn check_other_axes(data: &AxisData, campaign: &Campaign, poses: &Poses) -> Result<(), Error> {
    let machine = &campaign.machine;
    for pose in &data.poses {
        let content = &data.runs[pose.run];
        let step = poses.observations[pose.index].step;
        let (positions, first) = (&campaign.steps[step].positions, &content.positions);
        let chains = content.targets.iter().map(|&t| campaign.targets[t].carrier);
        for &other in chains.flat_map(|carrier| machine.chain(carrier)) {
            if other == data.axis {
                continue;
            }
            let run = || campaign.runs[content.run].name.clone();
            let other_name = || machine.axes()[other].name().to_owned();
            if positions[other].total_cmp(&first[other]).is_ne() {
                return Err(Error::SeveralAxesMove {
                    run: run(),
                    axis: machine.axes()[data.axis].name().to_owned(),
                    other: other_name(),
                    step: step_in_words(campaign, step),
                });
            }
            let rotary = machine.axes()[other].kind() == AxisKind::Rotary;
            if rotary && first[other].abs() > HOME_TOL_RAD {
                let (run, other_name) = (run(), other_name());
                let degrees = first[other].to_degrees();
                let away = trueaxis_poses::Error::not_identifiable(
                    format!(
                        "run {run}: rotary axis {other_name} stands at {degrees:.4}° instead of home"
                    ),
                    format!("measure this run with {other_name} at 0°"),
                );
                return Err(away.into());
            }
        }
    }
    Ok(())
}

fn number_nodes(data: &mut AxisData, campaign: &Campaign, poses: &Poses) {
    let node_of = |pose: &AxisPose| {
        let observation = &poses.observations[pose.index];
        Node {
            position: campaign.steps[observation.step].positions[data.axis],
            direction: observation.direction,
        }
    };
    let order = |a: &Node, b: &Node| {
        let by_position = a.position.total_cmp(&b.position);
        by_position.then(a.direction.cmp(&b.direction))
    };
    let own: Vec<Node> = data.poses.iter().map(node_of).collect();
    let mut nodes = own.clone();
    nodes.sort_by(order);
    nodes.dedup_by(|a, b| order(a, b).is_eq());
    data.poses_of = vec![Vec::new(); nodes.len()];
    for (i, (pose, own)) in data.poses.iter_mut().zip(&own).enumerate() {
        pose.node = nodes.partition_point(|node| order(node, own).is_lt());
        data.poses_of[pose.node].push(i);
    }
    data.nodes = nodes;
}

/// The pivot of a pose is the mean position of its targets. Without noise of their own all poses count alike.
fn weigh_poses(data: &mut AxisData, poses: &Poses) {
    let variance_mm2 = |pose: &AxisPose| {
        let own = poses.noise.own.get(pose.index);
        own.map_or(1.0, |own| own.fixed_view::<3, 3>(0, 0).trace())
    };
    let precisions: Vec<f64> = data.poses.iter().map(|r| variance_mm2(r).recip()).collect();
    for of_node in &data.poses_of {
        let sum: f64 = of_node.iter().map(|&i| precisions[i]).sum();
        let alike = 1.0 / of_node.len() as f64;
        for &i in of_node {
            data.poses[i].weight = match sum.is_finite() {
                true => precisions[i] / sum,
                false => alike,
            };
        }
    }
}

impl AxisData {
    /// The nodes and weights whose weighted sum is the curve at `position` ([`weights_at`]).
    pub(crate) fn weights_at(&self, position: f64) -> Vec<(usize, f64)> {
        weights_at(&self.nodes, position)
    }
}

impl RunData {
    fn new(campaign: &Campaign, poses: &Poses, first: &PoseObservation, run: usize) -> Self {
        let step = &campaign.steps[first.step];
        let (machine, axis) = (&campaign.machine, campaign.runs[run].axis);
        let targets = poses.bodies[first.body].targets.clone();
        let carriers = targets.iter().filter_map(|&t| campaign.targets[t].carrier);
        let carrier = carriers.clone().max_by_key(|&c| machine.chain(c).len());
        let (outer, inner) = around(machine, carrier.unwrap_or(axis), axis);
        Self {
            run,
            body: first.body,
            outer: outer.to_vec(),
            inner: inner.to_vec(),
            inside: carriers
                .map(|c| around(machine, c, axis).1.to_vec())
                .collect(),
            targets,
            positions: step.positions.clone(),
        }
    }
}

/// The axes before and after `axis` in the chain of a carrier.
fn around(machine: &Machine, carrier: usize, axis: usize) -> (&[usize], &[usize]) {
    let chain = machine.chain(carrier);
    let place = chain.iter().position(|&a| a == axis).unwrap_or(0);
    (&chain[..place], &chain[place + 1..])
}
