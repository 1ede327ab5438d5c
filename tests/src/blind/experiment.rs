//! Measures: every length is the distance of two exactly placed points.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Instrument, LengthReading, Lengths, Run};
use trueaxis_campaign::{Station, Stop, Target};
use trueaxis_kinematics::MICROMETRE;

use super::course::Instant;
use super::disturbance::Disturbance;
use super::hidden::Reading;
use super::layout::Layout;
use super::random::{Purpose, Random};
use super::schedule::{Schedule, Visit};
use super::setup::Setup;
use super::{Hidden, Kind, station_name};

/// A machine on which a campaign is measured, undisturbed or disturbed.
pub(super) struct Experiment {
    pub(super) kind: Kind,
    pub(super) layout: Layout,
    pub(super) schedule: Schedule,
    pub(super) setup: Setup,
    seed: u64,
}

/// Lengths are given in steps of 1e-7 mm, a thousandth of the best interferometer's resolution.
const LENGTHS_PER_MM: f64 = 1e7;

impl Experiment {
    pub(super) fn new(kind: &Kind, seed: u64) -> Self {
        let layout = Layout::new(kind);
        Self {
            kind: *kind,
            schedule: Schedule::new(kind, &layout),
            setup: Setup::new(&layout, kind.stations, seed),
            layout,
            seed,
        }
    }

    /// All lengths without noise, mm.
    pub(super) fn exact_mm(&self, hidden: &[Hidden]) -> Vec<f64> {
        let mut lengths = Vec::with_capacity(self.schedule.readings());
        for visit in &self.schedule.visits {
            let readings = visit.readings.iter();
            lengths.extend(readings.map(|&reading| {
                let disturbance = self.disturbance(visit, reading, hidden);
                self.length_mm(visit, reading.0, &disturbance)
            }));
        }
        lengths
    }

    /// All lengths as they are read, mm: the machine returns to another place at every stop, and
    /// every length has noise of its own.
    pub(super) fn noisy_mm(&self, hidden: &[Hidden]) -> Vec<f64> {
        let mut random = Random::new(self.seed, Purpose::Noise);
        let noise = self.kind.noise;
        let mut lengths = Vec::with_capacity(self.schedule.readings());
        for visit in &self.schedule.visits {
            let return_um = match self.schedule.is_of_bed(visit) {
                true => 0.0,
                false => noise.return_um,
            };
            let return_mm = random.normal_vector() * (return_um * MICROMETRE);
            for &reading in &visit.readings {
                let mut disturbance = self.disturbance(visit, reading, hidden);
                disturbance.machine_mm += return_mm;
                let drawn = match self.kind.heavy_tails {
                    true => random.student(),
                    false => random.normal(),
                };
                let noise_mm = noise.length_um * MICROMETRE * drawn;
                let length_mm = self.length_mm(visit, reading.0, &disturbance) + noise_mm;
                lengths.push((length_mm * LENGTHS_PER_MM).round() / LENGTHS_PER_MM);
            }
        }
        lengths
    }

    /// Where a target is, reference frame, mm. The formula is that of [`Disturbance`].
    pub(super) fn point_mm(
        &self,
        visit: &Visit,
        target: usize,
        disturbance: &Disturbance,
    ) -> Point3<f64> {
        if self.schedule.is_of_bed(visit) {
            return self.setup.homes_mm[target] + disturbance.target_mm;
        }
        let mut positions = self.schedule.steps[visit.step].positions.clone();
        for &(axis, beyond) in &disturbance.axes {
            positions[axis] += beyond;
        }
        let home_mm = self.setup.homes_mm[target];
        let growth_mm = (home_mm - self.centroid_mm(target)) * disturbance.growth;
        let place = |home_mm: Point3<f64>| {
            let carrier = self.layout.targets[target].carrier;
            let errors = &self.setup.errors;
            self.layout
                .machine
                .position(errors, carrier, &positions, home_mm)
        };
        let point_mm = place(home_mm + growth_mm + disturbance.target_mm);
        let turned_mm = match disturbance.turn == Vector3::zeros() {
            true => Vector3::zeros(),
            false => disturbance
                .turn
                .cross(&(point_mm - place(self.centroid_mm(target)))),
        };
        point_mm + disturbance.machine_mm + turned_mm
    }

    fn length_mm(&self, visit: &Visit, target: usize, disturbance: &Disturbance) -> f64 {
        let point_mm = self.point_mm(visit, target, disturbance);
        let station_mm = self.setup.stations_mm[visit.station] + disturbance.station_mm;
        let distance_mm = (point_mm - station_mm).norm();
        (1.0 + disturbance.scale) * distance_mm + disturbance.zero_mm
            - self.setup.dead_paths_mm[visit.station]
    }

    /// Centroid at home of the targets on the stage of a target, mm.
    fn centroid_mm(&self, target: usize) -> Point3<f64> {
        let on_stage = self.on_stage_of(target);
        let sum: Vector3<f64> = on_stage
            .iter()
            .map(|&t| self.setup.homes_mm[t].coords)
            .sum();
        Point3::from(sum / on_stage.len() as f64)
    }

    /// The targets on the stage of a target, it included.
    pub(super) fn on_stage_of(&self, target: usize) -> Vec<usize> {
        let targets = &self.layout.targets;
        let together = |t: &usize| targets[*t].carrier == targets[target].carrier;
        (0..targets.len()).filter(together).collect()
    }

    /// The sum of all disturbances at a reading.
    fn disturbance(
        &self,
        visit: &Visit,
        (target, time_s): (usize, f64),
        hidden: &[Hidden],
    ) -> Disturbance {
        let step = &self.schedule.steps[visit.step];
        let axis = step.run.map_or(0, |run| self.layout.sweeps[run].axis);
        let part = |[from, to]: [f64; 2], x: f64| (x - from) / (to - from);
        let places = step.positions.iter().enumerate();
        let parts = places.map(|(axis, &position)| part(self.layout.range(axis), position));
        let parts: Vec<f64> = parts.collect();
        let reading = Reading {
            machine: &self.layout.machine,
            instant: Instant {
                time_s,
                progress: part(self.schedule.span_s(), time_s),
                occupation_progress: part(self.schedule.occupations_s[visit.station], time_s),
                occupation_elapsed_s: time_s - self.schedule.occupations_s[visit.station][0],
            },
            station: visit.station,
            target,
            axis,
            part: parts[axis],
            parts: &parts,
            direction: visit.direction,
            speed_per_s: visit.speed_per_s,
            positions: &step.positions,
        };
        let mut sum = Disturbance::default();
        for disturbance in hidden {
            disturbance.act_on(&reading, &mut sum);
        }
        sum
    }

    /// The campaign with these lengths.
    pub(super) fn campaign(&self, lengths_mm: &[f64]) -> Campaign {
        let (layout, declared) = (&self.layout, self.kind.declared);
        let targets = layout.targets.iter().map(|target| Target {
            name: target.name.to_owned(),
            home_mm: target.home_mm,
            carrier: target.carrier,
            ..Target::default()
        });
        let stations = (0..self.kind.stations).map(|i| Station {
            name: station_name(i),
            approx_mm: None,
            dead_path: None,
        });
        let runs = layout.sweeps.iter().map(|sweep| Run {
            name: layout.machine.axes()[sweep.axis].name().to_lowercase(),
            axis: sweep.axis,
        });
        Campaign {
            name: format!("blind {}", self.seed),
            date: None,
            operator: None,
            machine_name: layout.name.to_owned(),
            machine: layout.machine.clone(),
            expansions: Vec::new(),
            instrument: Instrument {
                name: "laser tracker".to_owned(),
                length_sigma_um: Some(declared.length_um),
                length_sigma_ppm: None,
                repeatability_um: Some(declared.return_um),
                ..Instrument::default()
            },
            targets: targets.collect(),
            stations: stations.collect(),
            known_lengths: Vec::new(),
            runs: runs.collect(),
            steps: self.schedule.steps.clone(),
            lengths: Some(self.lengths(lengths_mm)),
            points: None,
            verification: Vec::new(),
            point_checks: Vec::new(),
            notices: Vec::new(),
        }
    }

    fn lengths(&self, lengths_mm: &[f64]) -> Lengths {
        let mut lengths = Lengths::default();
        for visit in &self.schedule.visits {
            let first = lengths.readings.len();
            for &(target, time_s) in &visit.readings {
                let number = lengths.readings.len();
                lengths.readings.push(LengthReading {
                    time_s,
                    target,
                    length_mm: lengths_mm[number],
                    // Line 1 of the file is its header.
                    line: number + 2,
                });
            }
            lengths.stops.push(Stop {
                station: visit.station,
                repeat: visit.repeat,
                step: visit.step,
                direction: if visit.direction > 0.0 {
                    Direction::Forward
                } else {
                    Direction::Backward
                },
                readings: first..lengths.readings.len(),
            });
        }
        lengths
    }
}
