//! What was measured of one axis: its runs, records and nodes.

use nalgebra::Point3;
use trueaxis_campaign::{Campaign, Direction};
use trueaxis_kinematics::AxisKind;

use crate::interpolation::{Place, sides_of, weights_at};
use crate::measured::Measured;
use crate::record_chunks::{Chunk, chunks};
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
    /// The records side by side.
    pub(crate) chunks: Vec<Chunk>,
}

pub(crate) struct RunData {
    pub(crate) run: usize,
    /// Targets that the axis moves in this run, ascending; every record of the run has these.
    pub(crate) targets: Vec<usize>,
    /// Number of records.
    pub(crate) records: usize,
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

impl Record {
    /// The places of its targets within the group.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> {
        self.targets.iter().map(|&(_, place)| place)
    }
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

/// A rotary axis this close to home is at home, rad.
const HOME_TOL_RAD: f64 = 1e-9;

/// Sorts the measured groups by the axis under test.
pub(crate) fn by_axis(campaign: &Campaign, measured: &Measured) -> Result<Vec<AxisData>, Error> {
    let mut all: Vec<AxisData> = Vec::new();
    let axis_of = |step: usize| campaign.runs[campaign.steps[step].run].axis;
    let is_moved = |step: usize, target: usize| {
        let carrier = campaign.targets[target].carrier;
        campaign.machine.chain(carrier).contains(&axis_of(step))
    };
    let mut moves_some = vec![false; campaign.steps.len()];
    for group in &measured.groups {
        moves_some[group.step] |= group.targets.iter().any(|&t| is_moved(group.step, t));
    }
    for (group, content) in measured.groups.iter().enumerate() {
        let step = &campaign.steps[content.step];
        let axis = axis_of(content.step);
        // Targets that stand still are a group of their own.
        if moves_some[content.step] && !content.targets.iter().any(|&t| is_moved(content.step, t)) {
            continue;
        }
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
                    chunks: Vec::new(),
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
                    records: 0,
                    first_record: record,
                });
                data.runs.len() - 1
            });
        let moved = |&(_, &target): &(usize, &usize)| is_moved(content.step, target);
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
        content.records += 1;
        for &(target, _) in &targets {
            if let Err(place) = content.targets.binary_search(&target) {
                content.targets.insert(place, target);
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
    for data in &mut all {
        keep_common_targets(data, campaign, measured)?;
        check_other_axes(data, campaign, measured)?;
        data.chunks = chunks(&data.records, &measured.noise.batches);
    }
    // In the order of the machine's axes, whatever the order of measuring.
    all.sort_by_key(|data| data.axis);
    Ok(all)
}

/// Leaves out targets that were not measured at every step of a run: the shape of the targets is
/// the same function of the points at every step only if these are the same.
fn keep_common_targets(
    data: &mut AxisData,
    campaign: &Campaign,
    measured: &Measured,
) -> Result<(), Error> {
    for (r, run) in data.runs.iter_mut().enumerate() {
        let mut counts = vec![0; run.targets.len()];
        for record in data.records.iter().filter(|record| record.run == r) {
            for (count, target) in counts.iter_mut().zip(&run.targets) {
                *count += usize::from(record.targets.iter().any(|(t, _)| t == target));
            }
        }
        let counted = run.targets.iter().zip(counts);
        let common: Vec<usize> = counted
            .filter(|&(_, count)| count == run.records)
            .map(|(&target, _)| target)
            .collect();
        if common.len() < MIN_TARGETS {
            let incomplete = data
                .records
                .iter()
                .find(|record| record.run == r && record.targets.len() < run.targets.len());
            let step = incomplete.map_or(0, |record| measured.groups[record.group].step);
            return Err(Error::NotIdentifiable {
                what: format!(
                    "run {}: only {} target(s) were measured at all of its steps, three are needed \
                     (one is missing in {})",
                    campaign.runs[run.run].name,
                    common.len(),
                    describe::step(campaign, step),
                ),
                mend: "measure the missing targets, or leave out the rows of the steps that lack \
                       them"
                    .to_owned(),
            });
        }
        run.targets = common;
        for record in data.records.iter_mut().filter(|record| record.run == r) {
            record
                .targets
                .retain(|(target, _)| run.targets.contains(target));
        }
    }
    Ok(())
}

/// Other axes of the chain must stand still during a run, and rotary ones at home: their errors
/// would enter those of the axis under test, or turn them.
fn check_other_axes(
    data: &AxisData,
    campaign: &Campaign,
    measured: &Measured,
) -> Result<(), Error> {
    let machine = &campaign.machine;
    let positions_of =
        |record: &Record| &campaign.steps[measured.groups[record.group].step].positions;
    for record in &data.records {
        let run = &data.runs[record.run];
        let first = positions_of(&data.records[run.first_record]);
        let positions = positions_of(record);
        for &(target, _) in &record.targets {
            for &other in machine.chain(campaign.targets[target].carrier) {
                if other == data.axis {
                    continue;
                }
                let (run, axis) = (campaign.runs[run.run].name.clone(), &machine.axes()[other]);
                let other_name = axis.name().to_owned();
                if positions[other].total_cmp(&first[other]).is_ne() {
                    return Err(Error::SeveralAxesMove {
                        run,
                        axis: machine.axes()[data.axis].name().to_owned(),
                        other: other_name,
                        step: describe::step(campaign, measured.groups[record.group].step),
                    });
                }
                if axis.kind() == AxisKind::Rotary && first[other].abs() > HOME_TOL_RAD {
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
    }
    Ok(())
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

/// The points of a record in the order of its targets; `points_mm` are those of all groups.
pub(crate) fn points_of<'a>(
    measured: &Measured,
    points_mm: &'a [Point3<f64>],
    record: &'a Record,
) -> impl Iterator<Item = (usize, Point3<f64>)> + 'a {
    let first = measured.groups[record.group].points.start;
    record
        .targets
        .iter()
        .map(move |&(target, place)| (target, points_mm[first + place]))
}
