//! Derivatives of the lengths by the parameters of the base model: central differences of exact
//! distances.

use nalgebra::{DMatrix, DVector, Point3, Rotation3, Vector3};

use super::disturbance::Disturbance;
use super::experiment::Experiment;
use super::schedule::Visit;

/// Difference for derivatives, mm: lengths of 1 m are exact to 1e-13 mm, so slopes to 1e-10; their
/// curvature adds less than that.
const DIFFERENCE_MM: f64 = 1e-3;
/// The same for angles, rad: it moves a point that is 1 m away by as much.
const DIFFERENCE_RAD: f64 = 1e-6;

/// The undisturbed readings, and how their lengths change with the parameters of the base model.
pub(super) struct Derivatives<'a> {
    experiment: &'a Experiment,
    readings: Vec<PlacedReading<'a>>,
    /// Middle of the points of each step, mm.
    centres_mm: Vec<Point3<f64>>,
}

struct PlacedReading<'a> {
    visit: &'a Visit,
    target: usize,
    point_mm: Point3<f64>,
}

impl<'a> Derivatives<'a> {
    pub(super) fn new(experiment: &'a Experiment) -> Self {
        let mut readings = Vec::new();
        let steps = experiment.schedule.steps.len();
        let mut sums = vec![(Vector3::zeros(), 0.0); steps];
        for visit in &experiment.schedule.visits {
            for &(target, _) in &visit.readings {
                let point_mm = experiment.point_mm(visit, target, &Disturbance::default());
                let (sum, count) = &mut sums[visit.step];
                *sum += point_mm.coords;
                *count += 1.0;
                readings.push(PlacedReading {
                    visit,
                    target,
                    point_mm,
                });
            }
        }
        let centres = sums
            .into_iter()
            .map(|(sum, count)| Point3::from(sum / count));
        Self {
            experiment,
            readings,
            centres_mm: centres.collect(),
        }
    }

    /// Rows of the readings at a step.
    pub(super) fn rows_of(&self, step: usize) -> Vec<usize> {
        let rows = 0..self.readings.len();
        rows.filter(|&row| self.readings[row].visit.step == step)
            .collect()
    }

    /// Derivatives of all lengths by the pose of their step: three shifts, three rotations about the
    /// middle of its points.
    pub(super) fn poses(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.readings.len(), 6, |row, column| {
            let PlacedReading {
                visit, point_mm, ..
            } = &self.readings[row];
            let centre_mm = self.centres_mm[visit.step];
            let station_mm = self.experiment.setup.stations_mm[visit.station];
            let distance_mm = |h: f64| {
                let moved = if column < 3 {
                    point_mm + Vector3::ith(column, h)
                } else {
                    let turn = Rotation3::new(Vector3::ith(column - 3, h));
                    centre_mm + turn * (point_mm - centre_mm)
                };
                (moved - station_mm).norm()
            };
            let h = if column < 3 {
                DIFFERENCE_MM
            } else {
                DIFFERENCE_RAD
            };
            slope(distance_mm, h)
        })
    }

    /// Derivatives of all lengths by dead paths, stations, constants of reflectors and targets. The poses take every common
    /// motion of the stations and of the targets of a stage, so both move only against each other.
    pub(super) fn shared(&self) -> DMatrix<f64> {
        let setup = &self.experiment.setup;
        let mut columns = Vec::new();
        for station in 0..setup.stations_mm.len() {
            columns.push(self.column(|reading, _| {
                let own = reading.visit.station == station;
                if own { -1.0 } else { 0.0 }
            }));
        }
        for (station, direction) in deformations(&setup.stations_mm) {
            columns.push(self.column(|reading, _| {
                if reading.visit.station != station {
                    return 0.0;
                }
                let station_mm = setup.stations_mm[station];
                let distance = |h: f64| (reading.point_mm - (station_mm + direction * h)).norm();
                slope(distance, DIFFERENCE_MM)
            }));
        }
        // What the reflectors' constants have in common is dead path.
        for target in 1..setup.homes_mm.len() {
            columns.push(self.column(|reading, _| {
                let own = reading.target == target;
                if own { 1.0 } else { 0.0 }
            }));
        }
        for target in 0..setup.homes_mm.len() {
            let stage = self.experiment.on_stage_of(target);
            if stage[0] != target {
                continue;
            }
            let homes: Vec<Point3<f64>> = stage.iter().map(|&t| setup.homes_mm[t]).collect();
            // No pose takes a motion of the bed.
            let moved = match self.experiment.layout.targets[target].carrier {
                Some(_) => deformations(&homes),
                None => free(homes.len()),
            };
            for (place, direction) in moved {
                columns.push(self.column(|reading, station_mm| {
                    if reading.target != stage[place] {
                        return 0.0;
                    }
                    let distance = |h: f64| {
                        let disturbance = Disturbance {
                            target_mm: direction * h,
                            ..Disturbance::default()
                        };
                        let point =
                            self.experiment
                                .point_mm(reading.visit, stage[place], &disturbance);
                        (point - station_mm).norm()
                    };
                    slope(distance, DIFFERENCE_MM)
                }));
            }
        }
        DMatrix::from_columns(&columns)
    }

    /// A value for every reading and its station.
    fn column(&self, value: impl Fn(&PlacedReading<'_>, Point3<f64>) -> f64) -> DVector<f64> {
        let stations_mm = &self.experiment.setup.stations_mm;
        let values = self.readings.iter();
        DVector::from_iterator(
            self.readings.len(),
            values.map(|reading| value(reading, stations_mm[reading.visit.station])),
        )
    }
}

/// Central difference.
fn slope(f: impl Fn(f64) -> f64, h: f64) -> f64 {
    (f(h) - f(-h)) / (2.0 * h)
}

/// All displacements of single points.
fn free(points: usize) -> Vec<(usize, Vector3<f64>)> {
    let directions = [Vector3::x(), Vector3::y(), Vector3::z()];
    let of_point = |point| directions.map(|direction| (point, direction));
    (0..points).flat_map(of_point).collect()
}

/// Independent displacements of single points that change their distances: the first point stays, the
/// second moves along the line between them, the third in the plane of the three, all others freely.
fn deformations(points: &[Point3<f64>]) -> Vec<(usize, Vector3<f64>)> {
    let mut all = Vec::new();
    let along = |i: usize| (points[i] - points[0]).normalize();
    for i in 1..points.len() {
        let first = along(1);
        let directions = match i {
            1 => vec![first],
            2 => {
                let across = along(2) - first * first.dot(&along(2));
                vec![first, across.normalize()]
            }
            _ => vec![Vector3::x(), Vector3::y(), Vector3::z()],
        };
        all.extend(directions.into_iter().map(|direction| (i, direction)));
    }
    all
}
