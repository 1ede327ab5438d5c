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

use nalgebra::Vector3;
use trueaxis_campaign::{
    Campaign, Direction, LengthReading, Lengths, LoggedColumn, LoggedQuantity, Stop,
};
use trueaxis_effects::{
    Circumstances, Displaced, Medium, Scene, SceneTarget, SceneTemperature, TemperatureHistory,
};
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{Network, Solution};

use crate::lengths::network::Group;

/// What a length depends on beside its point.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthCircumstances {
    /// Time on the clock of the campaign, s.
    pub time_s: f64,
    elapsed_s: f64,
    progress: f64,
    /// Progress of time within the occupation of the station, 0 to 1.
    pub occupation_progress: f64,
    /// Time since the first reading of the occupation, s.
    pub occupation_elapsed_s: f64,
    /// The station.
    pub station: usize,
    /// The target.
    pub target: usize,
    /// Repeat, from 1.
    pub repeat: u32,
    /// The outermost axis that moves the target; none on the bed.
    pub carrier: Option<usize>,
    /// The axis that moves; the first for a target on the bed.
    pub axis: usize,
    /// Side of approach.
    pub direction: Direction,
    speed_per_s: f64,
    /// The step of the campaign.
    pub step: usize,
    /// Number of the sweep: one axis, one repeat, one side of approach, from one station, in time order.
    pub sweep: usize,
    /// Its number within the occupation of the station.
    pub sweep_of_occupation: usize,
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
        stations: match campaign.points {
            // Coordinates are measured in the frame of an instrument, wherever it stands.
            Some(_) if campaign.lengths.is_none() => Vec::new(),
            _ => campaign.stations.iter().map(|s| s.name.clone()).collect(),
        },
        targets: targets.collect(),
        moving,
        temperatures: temperatures_of(campaign)
            .map(|(column, medium)| SceneTemperature {
                column: column.name.clone(),
                medium,
            })
            .collect(),
    }
}

/// The logged temperatures that effects may go with: those of the machine, and that of air which the instrument
/// does not compensate.
fn temperatures_of(campaign: &Campaign) -> impl Iterator<Item = (&LoggedColumn, Medium)> {
    let compensated = campaign.instrument.air_compensated;
    let columns = campaign.lengths.iter().flat_map(|lengths| &lengths.logged);
    columns.filter_map(move |column| match column.quantity()? {
        LoggedQuantity::MachineTemperature => Some((column, Medium::Machine)),
        LoggedQuantity::AirTemperature if !compensated => Some((column, Medium::Air)),
        _ => None,
    })
}

/// The courses of the temperatures of the scene ([`scene_of`]), as they were logged.
pub fn temperature_histories(campaign: &Campaign) -> Vec<TemperatureHistory> {
    let logged = campaign.lengths.iter().flat_map(|lengths| {
        let columns = temperatures_of(campaign);
        columns.map(|(column, _)| lengths.course(column))
    });
    logged
        .map(|c| TemperatureHistory::from_logged(&c))
        .collect()
}

/// The circumstances of the readings with the numbers `kept` (ascending), in measuring order.
///
/// `network` and `groups` are those of the campaign ([`network_from_campaign`](crate::network_from_campaign)).
pub fn length_circumstances(
    campaign: &Campaign,
    lengths: &Lengths,
    network: &Network,
    groups: &[Group],
    kept: &[usize],
) -> Vec<LengthCircumstances> {
    let campaign_span = Span::of(&lengths.readings);
    let occupation = |station: usize| {
        let stops = lengths.stops.iter().filter(|stop| stop.station == station);
        Span::of(stops.flat_map(|stop| &lengths.readings[stop.readings.clone()]))
    };
    let occupations: Vec<Span> = (0..campaign.stations.len()).map(occupation).collect();
    // Where each target is at each step (and side of approach): its group and the number of its point.
    let mut place_of = HashMap::new();
    for (g, (group, points)) in groups.iter().zip(&network.groups).enumerate() {
        for (&target, point) in group.targets.iter().zip(points.clone()) {
            // Targets on the bed stand at one place, whatever the step.
            let step = campaign.steps[group.step].run.map(|_| group.step);
            place_of.insert((step, group.direction, target), (g, point));
        }
    }
    let key = |stop: &Stop| sweep_of(campaign, stop);
    let sweeps = lengths.stops.chunk_by(|a, b| key(a) == key(b));
    let (mut before, mut sweep_of_occupation) = (None, 0);
    let mut all = Vec::with_capacity(kept.len());
    for (sweep, stops) in sweeps.enumerate() {
        let (station, repeat, run, direction) = key(&stops[0]);
        let axis = run.map_or(0, |run| campaign.runs[run].axis);
        let speed_per_s = match run {
            Some(_) => speed_per_s(campaign, lengths, stops, axis),
            None => 0.0,
        };
        let same_occupation = before.replace(station) == Some(station);
        sweep_of_occupation = if same_occupation {
            sweep_of_occupation + 1
        } else {
            0
        };
        let readings = stops.iter().flat_map(|stop| {
            let readings = stop.readings.clone();
            readings.map(|i| (stop.step, i, &lengths.readings[i]))
        });
        for (step, i, reading) in readings {
            let of_run = run.map(|_| step);
            let place = |side| place_of.get(&(of_run, side, reading.target));
            let place = place(None).or_else(|| place(Some(direction)));
            let Some(&(group, point)) = place.filter(|_| kept.binary_search(&i).is_ok()) else {
                continue;
            };
            all.push(LengthCircumstances {
                time_s: reading.time_s,
                elapsed_s: reading.time_s - campaign_span.first_s,
                progress: campaign_span.progress(reading.time_s),
                occupation_progress: occupations[station].progress(reading.time_s),
                occupation_elapsed_s: reading.time_s - occupations[station].first_s,
                station,
                target: reading.target,
                repeat,
                carrier: campaign.targets[reading.target].carrier,
                axis,
                direction,
                speed_per_s,
                step,
                sweep,
                sweep_of_occupation,
                point,
                group,
            });
        }
    }
    all
}

/// What stops that follow each other share in one sweep: station, repeat, run and side of approach.
pub(crate) fn sweep_of(campaign: &Campaign, stop: &Stop) -> (usize, u32, Option<usize>, Direction) {
    let run = campaign.steps[stop.step].run;
    (stop.station, stop.repeat, run, stop.direction)
}

/// From the first to the last of some readings, s.
struct Span {
    first_s: f64,
    last_s: f64,
}

impl Span {
    fn of<'a>(readings: impl IntoIterator<Item = &'a LengthReading>) -> Self {
        let empty = Self {
            first_s: f64::INFINITY,
            last_s: f64::NEG_INFINITY,
        };
        readings.into_iter().fold(empty, |span, reading| Self {
            first_s: span.first_s.min(reading.time_s),
            last_s: span.last_s.max(reading.time_s),
        })
    }

    /// How much of it has passed, 0 to 1.
    fn progress(&self, time_s: f64) -> f64 {
        match self.last_s > self.first_s {
            true => (time_s - self.first_s) / (self.last_s - self.first_s),
            false => 0.0,
        }
    }
}

/// Part of their median by which the speeds between neighbouring stops differ at most if the feed is constant.
const CONSTANT_FEED: f64 = 0.02;

/// Speed of an axis in a sweep, mm/s or rad/s with sign, if the machine may be moving there: single readings
/// whose positions grow in proportion to time. Several readings at one stop show that it stands still.
fn speed_per_s(campaign: &Campaign, lengths: &Lengths, sweep: &[Stop], axis: usize) -> f64 {
    if sweep.len() < 3 || sweep.iter().any(|stop| stop.readings.len() != 1) {
        return 0.0;
    }
    let time_s = |stop: &Stop| lengths.readings[stop.readings.start].time_s;
    let position = |stop: &Stop| campaign.steps[stop.step].positions[axis];
    let course: Vec<[f64; 2]> = sweep.iter().map(|s| [time_s(s), position(s)]).collect();
    constant_feed_per_s(&course)
}

/// Speed with sign of a motion from stop to stop, given as times and positions, if nine in ten speeds between neighbours
/// differ from their median by at most 2 %; else 0. Zero for fewer than two stops.
pub fn constant_feed_per_s(course: &[[f64; 2]]) -> f64 {
    // Sweeps of one target each follow one another in one key: a jump back is no motion.
    let between = course.windows(2).map(|pair| {
        let [from, to] = [pair[0], pair[1]];
        (to[1] - from[1]) / (to[0] - from[0])
    });
    let mut between: Vec<f64> = between.collect();
    between.sort_by(f64::total_cmp);
    let Some(&median) = between.get(between.len() / 2) else {
        return 0.0;
    };
    let alike = |v: &&f64| (*v - median).abs() <= CONSTANT_FEED * median.abs();
    let constant = 10 * between.iter().filter(alike).count() >= 9 * between.len();
    match median.is_finite() && constant {
        true => median,
        false => 0.0,
    }
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
    /// The length at the adjusted places of points and stations; `temperatures` are the courses of those of the scene
    /// ([`temperature_histories`]).
    pub fn observation<'a>(
        &self,
        campaign: &'a Campaign,
        network: &Network,
        solution: &Solution,
        temperatures: &'a [TemperatureHistory],
    ) -> Observation<'a> {
        let point_mm = solution.points_mm[self.point];
        let beam = point_mm - solution.stations[self.station].position_mm;
        let distance_mm = beam.norm();
        Observation {
            at: Circumstances {
                machine: &campaign.machine,
                time_s: self.time_s,
                elapsed_s: self.elapsed_s,
                progress: self.progress,
                occupation_progress: self.occupation_progress,
                occupation_elapsed_s: self.occupation_elapsed_s,
                station: self.station,
                target: self.target,
                carrier: self.carrier,
                axis: self.axis,
                direction: self.sign(),
                speed_per_s: self.speed_per_s,
                positions: &campaign.steps[self.step].positions,
                point_mm,
                stage: None,
                centroid_mm: centroid(&solution.points_mm[network.groups[self.group].clone()]),
                distance_mm,
                temperatures,
            },
            beam: beam / distance_mm,
        }
    }

    /// Side of approach, +1 or -1.
    pub fn sign(&self) -> f64 {
        f64::from(self.direction.sign())
    }
}
