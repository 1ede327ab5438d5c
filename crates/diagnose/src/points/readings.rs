//! The circumstances of every measured point.

use std::collections::HashMap;
use std::ops::Range;

use nalgebra::{Matrix3, Point3};
use trueaxis_campaign::{Campaign, Points, Stop};
use trueaxis_poses::constant_feed_per_s;

use crate::numbers::extremes;

/// A measured point.
#[derive(Debug, Clone)]
pub(crate) struct Reading {
    /// Its index among the points of the campaign.
    pub(crate) number: usize,
    /// Its line in the table.
    pub(crate) line: usize,
    pub(crate) time_s: f64,
    pub(crate) elapsed_s: f64,
    /// Progress of time over the campaign, 0 to 1.
    pub(crate) progress: f64,
    pub(crate) step: usize,
    /// The axis of its run; `None` for a target on the bed.
    pub(crate) axis: Option<usize>,
    /// Side of approach, +1 or -1.
    pub(crate) side: f64,
    pub(crate) repeat: u32,
    /// Number of the sweep: one run, one repeat, one side, in time order.
    pub(crate) sweep: usize,
    /// Speed of the axis if the machine may be moving, mm/s or rad/s.
    pub(crate) speed_per_s: f64,
    pub(crate) target: usize,
    /// The outermost axis that moves it; `None` on the bed.
    pub(crate) carrier: Option<usize>,
    /// Index of its pose; `None` on the bed.
    pub(crate) pose: Option<usize>,
    /// Index in the shapes of all stages.
    pub(crate) shape: usize,
    /// From the instrument's frame to the directions of its rows.
    pub(crate) rows: Matrix3<f64>,
    /// From the machine's axes to the same.
    pub(crate) rows_from_machine: Matrix3<f64>,
    /// Standard deviations along its rows as declared or shown, relative to 1 µm.
    pub(crate) relative: [f64; 3],
    /// Measured position, in the instrument's frame, mm.
    pub(crate) measured_mm: Point3<f64>,
}

/// The points of a campaign in measuring order, stop by stop.
#[derive(Debug, Clone)]
pub(crate) struct Readings {
    pub(crate) all: Vec<Reading>,
    /// The readings of each stop.
    pub(crate) stops: Vec<Range<usize>>,
    /// The step of each pose.
    pub(crate) steps: Vec<usize>,
    /// For each place in the shapes its target, and the run if that target is rigid with others only in this run.
    pub(crate) shapes: Vec<(Option<usize>, usize)>,
}

impl Readings {
    /// The readings of a campaign except the points with the numbers `removed`.
    ///
    /// Targets that the axis of a run does not move are left out of this run, as in the calibration.
    pub(crate) fn new(campaign: &Campaign, points: &Points, removed: &[usize]) -> Self {
        let [first_s, last_s] = extremes(points.readings.iter().map(|r| r.time_s));
        let duration_s = last_s - first_s;
        let mut new = Self {
            all: Vec::new(),
            stops: Vec::new(),
            steps: Vec::new(),
            shapes: Vec::new(),
        };
        let (mut pose_of, mut shape_of) = (HashMap::new(), HashMap::new());
        let several = on_several_carriers(campaign, points);
        let key = |stop: &Stop| (stop.repeat, campaign.steps[stop.step].run, stop.direction);
        let sweeps = points.stops.chunk_by(|a, b| key(a) == key(b));
        for (sweep, stops) in sweeps.enumerate() {
            let run = campaign.steps[stops[0].step].run;
            let axis = run.map(|run| campaign.runs[run].axis);
            let speed_per_s = axis.map_or(0.0, |axis| speed_per_s(campaign, points, stops, axis));
            for stop in stops {
                let first = new.all.len();
                for number in stop.readings.clone() {
                    let reading = &points.readings[number];
                    let carrier = campaign.targets[reading.target].carrier;
                    let is_moved = is_moved(campaign, axis, reading.target);
                    if !is_moved || removed.contains(&number) {
                        continue;
                    }
                    let pose = axis.map(|_| {
                        let steps = &mut new.steps;
                        *pose_of.entry(stop.step).or_insert_with(|| {
                            steps.push(stop.step);
                            steps.len() - 1
                        })
                    });
                    let only = run.filter(|&run| several[run]);
                    let shapes = &mut new.shapes;
                    let shape = *shape_of.entry((only, reading.target)).or_insert_with(|| {
                        shapes.push((only, reading.target));
                        shapes.len() - 1
                    });
                    let elapsed_s = reading.time_s - first_s;
                    new.all.push(Reading {
                        number,
                        line: reading.line,
                        time_s: reading.time_s,
                        elapsed_s,
                        progress: if duration_s > 0.0 {
                            elapsed_s / duration_s
                        } else {
                            0.0
                        },
                        step: stop.step,
                        axis,
                        side: f64::from(stop.direction.sign()),
                        repeat: stop.repeat,
                        sweep,
                        speed_per_s,
                        target: reading.target,
                        carrier,
                        pose,
                        shape,
                        rows: Matrix3::identity(),
                        rows_from_machine: Matrix3::identity(),
                        relative: [reading.sigma_um.unwrap_or(1.0); 3],
                        measured_mm: reading.position_mm,
                    });
                }
                if new.all.len() > first {
                    new.stops.push(first..new.all.len());
                }
            }
        }
        new
    }
}

/// Whether the axis of a run moves a target; without an axis, whether the target is on the bed.
fn is_moved(campaign: &Campaign, axis: Option<usize>, target: usize) -> bool {
    let carrier = campaign.targets[target].carrier;
    match axis {
        Some(axis) => campaign.machine.chain(carrier).contains(&axis),
        None => carrier.is_none(),
    }
}

/// For each run whether the targets that it moves are on several carriers: they are one rigid body only in this run.
fn on_several_carriers(campaign: &Campaign, points: &Points) -> Vec<bool> {
    let mut carriers: Vec<Vec<Option<usize>>> = vec![Vec::new(); campaign.runs.len()];
    for stop in &points.stops {
        let Some(run) = campaign.steps[stop.step].run else {
            continue;
        };
        for reading in &points.readings[stop.readings.clone()] {
            let carrier = campaign.targets[reading.target].carrier;
            let axis = Some(campaign.runs[run].axis);
            if is_moved(campaign, axis, reading.target) && !carriers[run].contains(&carrier) {
                carriers[run].push(carrier);
            }
        }
    }
    carriers.iter().map(|own| own.len() > 1).collect()
}

/// Signed speed of an axis in a sweep, if the machine may be moving there: all points of a stop at one time, and
/// positions that grow in proportion to time. Otherwise 0.
fn speed_per_s(campaign: &Campaign, points: &Points, sweep: &[Stop], axis: usize) -> f64 {
    let time_s = |stop: &Stop| points.readings[stop.readings.start].time_s;
    let at_one_time = |stop: &Stop| {
        let mut readings = points.readings[stop.readings.clone()].iter();
        readings.all(|reading| reading.time_s <= time_s(stop))
    };
    if sweep.len() < 3 || !sweep.iter().all(at_one_time) {
        return 0.0;
    }
    let position = |stop: &Stop| campaign.steps[stop.step].positions[axis];
    let course: Vec<[f64; 2]> = sweep.iter().map(|s| [time_s(s), position(s)]).collect();
    constant_feed_per_s(&course)
}
