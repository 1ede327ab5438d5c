//! What was measured of one axis: its runs, records and nodes.

use nalgebra::Point3;
use trueaxis_campaign::{Campaign, Direction};

use crate::measured::Measured;
use crate::{Error, describe};

/// All measurements of one axis.
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
    /// Targets that the axis moves in this run.
    pub(crate) targets: Vec<usize>,
    /// For each target the records in which it was measured.
    pub(crate) measured: Vec<usize>,
    /// The first record: where the other axes stand.
    pub(crate) first_record: usize,
}

pub(crate) struct Record {
    /// Index into [`AxisData::runs`].
    pub(crate) run: usize,
    /// Measured group.
    pub(crate) group: usize,
    /// Index into [`AxisData::nodes`].
    pub(crate) node: usize,
    /// For each moved target: its number and its place within the group.
    pub(crate) targets: Vec<(usize, usize)>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Node {
    /// mm or rad.
    pub(crate) position: f64,
    /// Side of approach, where kept apart.
    pub(crate) direction: Option<Direction>,
    /// Records at this node.
    pub(crate) records: usize,
}

/// Targets needed to see six component errors.
const MIN_TARGETS: usize = 3;

/// Sorts the measured groups by the axis under test.
pub(crate) fn by_axis(campaign: &Campaign, measured: &Measured) -> Result<Vec<AxisData>, Error> {
    let mut all: Vec<AxisData> = Vec::new();
    for (group, content) in measured.groups.iter().enumerate() {
        let step = &campaign.steps[content.step];
        let axis = campaign.runs[step.run].axis;
        let place = all
            .iter()
            .position(|data| data.axis == axis)
            .unwrap_or_else(|| {
                let empty = AxisData {
                    axis,
                    runs: Vec::new(),
                    records: Vec::new(),
                    nodes: Vec::new(),
                    sides: Vec::new(),
                };
                all.push(empty);
                all.len() - 1
            });
        let data = &mut all[place];
        let record = data.records.len();
        let run = data
            .runs
            .iter()
            .position(|r| r.run == step.run)
            .unwrap_or_else(|| {
                data.runs.push(RunData {
                    run: step.run,
                    targets: Vec::new(),
                    measured: Vec::new(),
                    first_record: record,
                });
                data.runs.len() - 1
            });
        let moved = |&(_, target): &(usize, &usize)| {
            campaign
                .machine
                .chain(campaign.targets[*target].carrier)
                .contains(&axis)
        };
        let targets: Vec<(usize, usize)> = content
            .targets
            .iter()
            .enumerate()
            .filter(moved)
            .map(|(i, &t)| (t, i))
            .collect();
        if targets.len() < MIN_TARGETS {
            return Err(Error::NotIdentifiable {
                what: format!(
                    "{}: {} of the targets that {} moves were measured, three are needed to see \
                     its six component errors",
                    describe::step(campaign, content.step),
                    targets.len(),
                    campaign.machine.axes()[axis].name(),
                ),
                mend: "measure the missing targets there, or leave out the rows of this step"
                    .to_owned(),
            });
        }
        let content = &mut data.runs[run];
        for &(target, _) in &targets {
            match content.targets.iter().position(|&t| t == target) {
                Some(place) => content.measured[place] += 1,
                None => {
                    content.targets.push(target);
                    content.measured.push(1);
                }
            }
        }
        data.records.push(Record {
            run,
            group,
            node: 0,
            targets,
        });
    }
    for data in &mut all {
        number_nodes(data, campaign, measured);
    }
    // In the order of the machine's axes, whatever the order of measuring.
    all.sort_by_key(|data| data.axis);
    Ok(all)
}

fn number_nodes(data: &mut AxisData, campaign: &Campaign, measured: &Measured) {
    let node_of = |record: &Record| {
        let content = &measured.groups[record.group];
        let position = campaign.steps[content.step].positions[data.axis];
        Node {
            position,
            direction: content.direction,
            records: 0,
        }
    };
    let order = |a: &Node, b: &Node| {
        a.position
            .total_cmp(&b.position)
            .then(a.direction.cmp(&b.direction))
    };
    let mut nodes: Vec<Node> = data.records.iter().map(node_of).collect();
    let own = nodes.clone();
    nodes.sort_by(order);
    nodes.dedup_by(|a, b| order(a, b).is_eq());
    for (record, own) in data.records.iter_mut().zip(&own) {
        record.node = nodes.partition_point(|node| order(node, own).is_lt());
        nodes[record.node].records += 1;
    }
    data.sides = [None, Some(Direction::Backward), Some(Direction::Forward)]
        .into_iter()
        .filter(|side| nodes.iter().any(|node| node.direction == *side))
        .collect();
    data.nodes = nodes;
}

impl AxisData {
    /// Weights of the nodes whose sum is the curve at `position`: linear interpolation, or the
    /// nearest node outside the range; the mean of both sides of approach where they are apart.
    pub(crate) fn weights_at(&self, position: f64) -> Vec<(usize, f64)> {
        let above = self.nodes.partition_point(|node| node.position < position);
        let (low, high) = self.nodes.split_at(above);
        let mut weights = Vec::new();
        // Nodes are in order of position, so the neighbours of each side are found at once.
        for &side in &self.sides {
            let below = low.iter().rposition(|node| node.direction == side);
            let above = high
                .iter()
                .position(|node| node.direction == side)
                .map(|k| above + k);
            match (below, above) {
                (Some(below), Some(above)) => {
                    let (a, b) = (self.nodes[below].position, self.nodes[above].position);
                    let weight = (position - a) / (b - a);
                    weights.push((below, 1.0 - weight));
                    weights.push((above, weight));
                }
                (Some(only), None) | (None, Some(only)) => weights.push((only, 1.0)),
                (None, None) => {}
            }
        }
        let sum: f64 = weights.iter().map(|&(_, weight)| weight).sum();
        weights.iter_mut().for_each(|(_, weight)| *weight /= sum);
        weights.retain(|&(_, weight)| weight > 0.0);
        weights
    }
}

/// The measured points of a record in the order of its targets.
pub(crate) fn points_of<'a>(
    measured: &'a Measured,
    record: &'a Record,
) -> impl Iterator<Item = (usize, Point3<f64>)> + 'a {
    let first = measured.groups[record.group].points.start;
    record
        .targets
        .iter()
        .map(move |&(target, place)| (target, measured.points_mm[first + place]))
}
