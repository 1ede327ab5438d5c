//! The circumstances of every length: when, from where, to what, on which sweep.
//!
//! What an effect beyond the rigid machine does to a length depends on them and on where station and
//! target are; with the displacements `D` of [`trueaxis_effects`] it is exactly
//!
//! ```text
//! |p + D_p - S - D_S| - |p - S| + D_l
//! ```
//!
//! with the adjusted `p` and `S`: their errors of some µm over a metre change it by a millionth.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Lengths, Stop};
use trueaxis_effects::{Circumstances, Displaced, Scene, SceneTarget};
use trueaxis_kinematics::Machine;
use trueaxis_multilateration::{Group, Network, Station};

/// What a length depends on beside its point.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthCircumstances {
    /// Time on the clock of the campaign, s.
    pub time_s: f64,
    elapsed_s: f64,
    progress: f64,
    /// Progress of time within the turn of the station, 0 to 1.
    pub turn_progress: f64,
    /// The station.
    pub station: usize,
    /// The target.
    pub target: usize,
    /// Repeat, from 1.
    pub repeat: u32,
    carrier: usize,
    /// The axis that moves.
    pub axis: usize,
    /// Side of approach.
    pub direction: Direction,
    speed_per_s: f64,
    /// The step of the campaign.
    pub step: usize,
    /// Number of the sweep: one axis, one repeat, one direction, from one station, in time order.
    pub sweep: usize,
    /// Its number within the turn of the station.
    pub sweep_of_turn: usize,
    /// Index among the points of the network.
    pub point: usize,
    group: usize,
}

/// What there is in a campaign that effects can happen to.
pub fn scene_of(campaign: &Campaign) -> Scene {
    let targets = campaign.targets.iter().map(|target| SceneTarget {
        name: target.name.clone(),
        carrier: target.carrier,
    });
    let mut moving: Vec<usize> = campaign.runs.iter().map(|run| run.axis).collect();
    moving.sort_unstable();
    moving.dedup();
    Scene {
        machine: campaign.machine.clone(),
        stations: campaign.stations.iter().map(|s| s.name.clone()).collect(),
        targets: targets.collect(),
        moving,
    }
}

/// The circumstances of the readings with the numbers `kept` (ascending), in measuring order.
///
/// `network` and `groups` are those of the campaign ([`trueaxis_multilateration::network_from_campaign`]).
pub fn length_circumstances(
    campaign: &Campaign,
    lengths: &Lengths,
    network: &Network,
    groups: &[Group],
    kept: &[usize],
) -> Vec<LengthCircumstances> {
    let span = |from: f64, to: f64, t: f64| {
        if to > from {
            (t - from) / (to - from)
        } else {
            0.0
        }
    };
    let times = lengths.readings.iter().map(|r| r.time_s);
    let first = times.clone().fold(f64::INFINITY, f64::min);
    let last = times.fold(f64::NEG_INFINITY, f64::max);
    let mut turns = vec![(f64::INFINITY, f64::NEG_INFINITY); campaign.stations.len()];
    for stop in &lengths.stops {
        for reading in &lengths.readings[stop.readings.clone()] {
            let turn = &mut turns[stop.station];
            *turn = (turn.0.min(reading.time_s), turn.1.max(reading.time_s));
        }
    }
    let speeds = speeds(campaign, lengths);
    // Where each target is at each step (and side of approach): its group and the number of its point.
    let mut place_of = HashMap::new();
    for (g, (group, points)) in groups.iter().zip(&network.groups).enumerate() {
        for (&target, point) in group.targets.iter().zip(points.clone()) {
            place_of.insert((group.step, group.direction, target), (g, point));
        }
    }
    let (mut sweep, mut sweep_of_turn) = (0, 0);
    let mut earlier: Option<SweepKey> = None;
    let mut all = Vec::with_capacity(kept.len());
    for (number, stop) in lengths.stops.iter().enumerate() {
        let step = &campaign.steps[stop.step];
        let key = sweep_key(campaign, stop);
        if let Some(earlier) = earlier.filter(|&earlier| earlier != key) {
            sweep += 1;
            sweep_of_turn = if earlier.0 == stop.station {
                sweep_of_turn + 1
            } else {
                0
            };
        }
        earlier = Some(key);
        for i in stop.readings.clone() {
            let reading = &lengths.readings[i];
            let place = |side| place_of.get(&(stop.step, side, reading.target));
            let place = place(None).or_else(|| place(Some(stop.direction)));
            let Some(&(group, point)) = place.filter(|_| kept.binary_search(&i).is_ok()) else {
                continue;
            };
            let t = reading.time_s;
            all.push(LengthCircumstances {
                time_s: t,
                elapsed_s: t - first,
                progress: span(first, last, t),
                turn_progress: span(turns[stop.station].0, turns[stop.station].1, t),
                station: stop.station,
                target: reading.target,
                repeat: stop.repeat,
                carrier: campaign.targets[reading.target].carrier,
                axis: campaign.runs[step.run].axis,
                direction: stop.direction,
                speed_per_s: speeds[number],
                step: stop.step,
                sweep,
                sweep_of_turn,
                point,
                group,
            });
        }
    }
    all
}

/// Station, repeat, run and direction.
type SweepKey = (usize, u32, usize, Direction);

fn sweep_key(campaign: &Campaign, stop: &Stop) -> SweepKey {
    let run = campaign.steps[stop.step].run;
    (stop.station, stop.repeat, run, stop.direction)
}

/// A feed is constant if the speeds between neighbouring stops differ by less than this part.
const CONSTANT_FEED: f64 = 0.02;

/// Speed of the moving axis at each stop, mm/s or rad/s with sign, if the machine may be moving there:
/// single readings along a sweep whose positions grow in proportion to time. Several readings at one
/// stop show that it stands still.
fn speeds(campaign: &Campaign, lengths: &Lengths) -> Vec<f64> {
    let mut speeds = Vec::with_capacity(lengths.stops.len());
    let same = |a: &Stop, b: &Stop| sweep_key(campaign, a) == sweep_key(campaign, b);
    for sweep in lengths.stops.chunk_by(same) {
        let axis = campaign.runs[campaign.steps[sweep[0].step].run].axis;
        let at = |stop: &Stop| {
            let time_s = lengths.readings[stop.readings.start].time_s;
            (time_s, campaign.steps[stop.step].positions[axis])
        };
        let single = sweep.iter().all(|stop| stop.readings.len() == 1);
        // Sweeps of one target each follow one another in one key: a jump back is no motion.
        let between = sweep.windows(2).map(|pair| {
            let (from, to) = (at(&pair[0]), at(&pair[1]));
            (to.1 - from.1) / (to.0 - from.0)
        });
        let mut between: Vec<f64> = between.collect();
        between.sort_by(f64::total_cmp);
        let median = between.get(between.len() / 2).copied().unwrap_or(0.0);
        let alike = |v: &&f64| (*v - median).abs() <= CONSTANT_FEED * median.abs();
        let constant = 10 * between.iter().filter(alike).count() >= 9 * between.len();
        let moving = single && sweep.len() > 2 && median.is_finite() && median != 0.0 && constant;
        speeds.resize(
            speeds.len() + sweep.len(),
            if moving { median } else { 0.0 },
        );
    }
    speeds
}

/// One observed length of an adjusted network.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
    /// Its circumstances.
    pub at: Circumstances<'a>,
    /// Unit vector from station to target.
    pub beam: Vector3<f64>,
}

impl Observation<'_> {
    /// By how much the length shown is longer for displacements, mm: the exact distance, not `u·D`.
    pub fn lengthening_mm(&self, by: &Displaced) -> f64 {
        let beam_mm = self.beam * self.at.distance_mm + by.point_mm - by.station_mm;
        beam_mm.norm() - self.at.distance_mm + by.length_mm
    }
}

impl LengthCircumstances {
    /// The length at the adjusted places of points and stations; `positions` are those of its step.
    pub fn observation<'a>(
        &self,
        machine: &'a Machine,
        positions: &'a [f64],
        network: &Network,
        stations: &[Station],
        points_mm: &[Point3<f64>],
    ) -> Observation<'a> {
        let stop_mm = &points_mm[network.groups[self.group].clone()];
        let sum: Vector3<f64> = stop_mm.iter().map(|p| p.coords).sum();
        let point_mm = points_mm[self.point];
        let beam = point_mm - stations[self.station].position_mm;
        let distance_mm = beam.norm();
        Observation {
            at: Circumstances {
                machine,
                time_s: self.time_s,
                elapsed_s: self.elapsed_s,
                progress: self.progress,
                turn_progress: self.turn_progress,
                station: self.station,
                target: self.target,
                carrier: self.carrier,
                axis: self.axis,
                direction: self.sign(),
                speed_per_s: self.speed_per_s,
                positions,
                point_mm,
                centroid_mm: Point3::from(sum / stop_mm.len() as f64),
                distance_mm,
            },
            beam: beam / distance_mm,
        }
    }

    /// Side of approach, +1 or -1.
    pub fn sign(&self) -> f64 {
        match self.direction {
            Direction::Forward => 1.0,
            Direction::Backward => -1.0,
        }
    }
}
