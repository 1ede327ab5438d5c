//! Poses and shapes of the targets, and the changes of the coordinates by these and by effects.
//!
//! The model is found by alternating best fits: each pose to the points of its step with fixed shapes, each shape to
//! the mean of its points with fixed poses (generalised Procrustes analysis; J. C. Gower, *Psychometrika* 40, 33,
//! 1975). Everything else is linear about it: `p = t + R h`,
//!
//! ```text
//! dp = δ + ε × (p - pivot) + R dh
//! ```

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Matrix3x6, Point3, Rotation3, Translation3, Vector3};
use trueaxis_campaign::{Campaign, Points};
use trueaxis_effects::{Circumstances, Displaced, ResolvedEffect, Scene};
use trueaxis_kinematics::{Ideal, best_fit};
use trueaxis_screening::{CoordinateNoise, CoordinateReading, StepReadings};
use trueaxis_selection::Hypothesis;

use crate::engine::disturbance::Disturbance;
use crate::numbers::distinct;
use crate::points::readings::{Reading, Readings};

/// The points of a campaign about one adjustment.
#[derive(Clone)]
pub(crate) struct Base<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) scene: &'a Scene,
    pub(crate) readings: Readings,
    /// From the datum (the best fit of all targets to their nominal positions) to the instrument.
    instrument_from_datum: Isometry3<f64>,
    /// Position of each point in the datum, and the centroid of the targets measured with it.
    places_mm: Vec<[Point3<f64>; 2]>,
    /// Measured less modelled coordinates, three for each point, along the directions of its rows, mm.
    pub(crate) misfit_mm: Vec<f64>,
    /// Changes of each point by its pose: translation, and rotation times an arm, mm per mm.
    pub(crate) by_pose: Vec<Matrix3x6<f64>>,
    /// Changes of each point by its place in the shape.
    pub(crate) by_shape: Vec<Matrix3<f64>>,
    /// Disturbances in the covariance of the points.
    pub(crate) disturbances: Vec<Disturbance>,
}

/// A shape has converged when no coordinate moves by more than this, mm: what is left is of second order.
const RESTS_MM: f64 = 1e-6;

const MOST_FITS: usize = 100;

/// Number of distinct targets that determine a pose.
const TARGETS_OF_A_POSE: usize = 3;

impl<'a> Base<'a> {
    /// Adjusts the points except those with the numbers `removed`.
    pub(crate) fn new(
        campaign: &'a Campaign,
        scene: &'a Scene,
        points: &Points,
        removed: &[usize],
    ) -> Self {
        let readings = Readings::new(campaign, points, removed);
        let machine = &campaign.machine;
        let nominal = |reading: &Reading| {
            let positions = &campaign.steps[reading.step].positions;
            let home_mm = campaign.targets[reading.target].home_mm;
            machine.position(&Ideal, reading.carrier, positions, home_mm)
        };
        let nominal_mm: Vec<Point3<f64>> = readings.all.iter().map(nominal).collect();
        let measured_mm: Vec<Point3<f64>> = readings.all.iter().map(|r| r.measured_mm).collect();
        let instrument_from_datum = best_fit(&nominal_mm, &measured_mm);

        // Motion of what the axis of the run carries to the nominal position of each point, and its shape there.
        let motion = |step: usize, carrier: Option<usize>| {
            machine.motion(&Ideal, carrier, &campaign.steps[step].positions)
        };
        let mut poses = vec![instrument_from_datum; readings.steps.len()];
        let mut shapes_mm = vec![Point3::origin(); readings.shapes.len()];
        for (reading, place_mm) in readings.all.iter().zip(&nominal_mm) {
            // Targets on several carriers are one body in their run, which moves with the axis under test.
            let only = readings.shapes[reading.shape].0;
            let carrier = only.map_or(reading.carrier, |_| reading.axis);
            let nominal = motion(reading.step, carrier);
            shapes_mm[reading.shape] = nominal.inverse() * place_mm;
            if let Some(pose) = reading.pose {
                poses[pose] = instrument_from_datum * nominal;
            }
        }
        let still = instrument_from_datum;
        let of_pose = of_pose(&readings);
        for _ in 0..MOST_FITS {
            for (pose, own) in poses.iter_mut().zip(&of_pose) {
                *pose = fitted(*pose, own, &readings, &shapes_mm);
            }
            let moved_mm = fit_shapes(&mut shapes_mm, &readings, &poses, &still);
            if moved_mm < RESTS_MM {
                break;
            }
        }
        let pose = |reading: &Reading| reading.pose.map_or(still, |pose| poses[pose]);
        let modelled = readings.all.iter().map(|r| pose(r) * shapes_mm[r.shape]);
        let modelled: Vec<Point3<f64>> = modelled.collect();
        let arms: Vec<Arm> = of_pose.iter().map(|own| Arm::of(own, &modelled)).collect();
        let by_shape = |r: &Reading| pose(r).rotation.to_rotation_matrix().into_inner();
        let misfit = readings.all.iter().zip(&modelled);
        let misfit_mm = misfit.flat_map(|(r, p)| <[f64; 3]>::from(r.measured_mm - p));
        let mut base = Self {
            campaign,
            scene,
            misfit_mm: misfit_mm.collect(),
            by_pose: by_pose(&readings, &modelled, &arms),
            by_shape: readings.all.iter().map(by_shape).collect(),
            places_mm: places_mm(&readings, &modelled, &instrument_from_datum),
            instrument_from_datum,
            disturbances: Vec::new(),
            readings,
        };
        base.turn_rows();
        base
    }

    /// Rotates the rows of each point to the directions in which its noise is independent.
    fn turn_rows(&mut self) {
        let noise = CoordinateNoise::estimated(&self.read_by_step());
        let instrument_from_machine = self.instrument_from_datum.rotation.to_rotation_matrix();
        for (i, reading) in self.readings.all.iter_mut().enumerate() {
            let (rows, variances) = noise.at(&reading.measured_mm);
            let declared = reading.relative;
            reading.relative = std::array::from_fn(|k| declared[k] * variances[k].sqrt());
            reading.rows = rows;
            reading.rows_from_machine = rows * instrument_from_machine.matrix();
            let own = &mut self.misfit_mm[3 * i..3 * i + 3];
            let turned = rows * Vector3::from_column_slice(own);
            own.copy_from_slice(turned.as_slice());
            self.by_pose[i] = rows * self.by_pose[i];
            self.by_shape[i] = rows * self.by_shape[i];
        }
    }

    /// What says how the noise of the coordinates depends on place and direction.
    fn read_by_step(&self) -> Vec<StepReadings> {
        let mut of = BTreeMap::new();
        for (visit, stop) in self.readings.stops.iter().enumerate() {
            for i in stop.clone() {
                let reading = &self.readings.all[i];
                // Targets on the bed are one more body, which stands still.
                let step = of.entry((reading.pose, reading.side > 0.0));
                let step = step.or_insert_with(|| StepReadings {
                    rotation: self.by_shape[i],
                    readings: Vec::new(),
                });
                step.readings.push(CoordinateReading {
                    visit,
                    target: reading.shape,
                    sigma: reading.relative[0],
                    point_mm: reading.measured_mm,
                    misfit_mm: Vector3::from_column_slice(&self.misfit_mm[3 * i..3 * i + 3]),
                });
            }
        }
        of.into_values().collect()
    }

    /// A vector in the instrument's frame along the rows of a point.
    pub(crate) fn in_rows(&self, i: usize, v: Vector3<f64>) -> Vector3<f64> {
        self.readings.all[i].rows * v
    }

    /// The rows of a point as a vector in the instrument's frame.
    pub(crate) fn of_rows(&self, i: usize, row: &[f64]) -> Vector3<f64> {
        self.readings.all[i].rows.transpose() * Vector3::from_column_slice(row)
    }

    /// From the rows of a point to the reference frame.
    pub(crate) fn reference_from_rows(&self, i: usize) -> Matrix3<f64> {
        self.readings.all[i].rows_from_machine.transpose()
    }

    /// The circumstances of a point.
    pub(crate) fn at(&self, i: usize) -> Circumstances<'_> {
        let reading = &self.readings.all[i];
        let [point_mm, centroid_mm] = self.places_mm[i];
        // The actual rotation, not the nominal one: a displacement out of the plane of three targets, which rotates
        // with them, is then part of the poses, and none of it can appear in place of the errors of their angles.
        let stage = self.reference_from_rows(i) * self.by_shape[i];
        Circumstances {
            machine: &self.scene.machine,
            time_s: reading.time_s,
            elapsed_s: reading.elapsed_s,
            progress: reading.progress,
            occupation_progress: reading.progress,
            occupation_elapsed_s: reading.elapsed_s,
            station: 0,
            target: reading.target,
            carrier: reading.carrier,
            axis: reading.axis.unwrap_or(0),
            direction: reading.side,
            speed_per_s: reading.speed_per_s,
            positions: &self.campaign.steps[reading.step].positions,
            point_mm,
            stage: reading
                .pose
                .map(|_| Rotation3::from_matrix_unchecked(stage)),
            centroid_mm,
            distance_mm: 0.0,
            temperatures: &[],
        }
    }

    /// Change of measured coordinates by a displacement: if the frame moves, the points move the other way.
    pub(crate) fn shown_mm(&self, by: &Displaced) -> Vector3<f64> {
        self.instrument_from_datum.rotation * (by.point_mm - by.station_mm)
    }

    /// Changes of all coordinates by a unit of each parameter of a hypothesis, mm.
    pub(crate) fn columns_at(&self, hypothesis: &Hypothesis, shape: f64) -> Vec<Vec<f64>> {
        let count = hypothesis.parameters(self.scene).len();
        let mut columns = vec![Vec::with_capacity(self.misfit_mm.len()); count];
        for i in 0..self.readings.all.len() {
            let at = self.at(i);
            for (k, column) in columns.iter_mut().enumerate() {
                let shown_mm = self.shown_mm(&hypothesis.form(k, shape, &at));
                column.extend(self.in_rows(i, shown_mm).iter());
            }
        }
        columns
    }

    /// Change of the `i`-th point by effects, in the instrument's frame, mm.
    pub(crate) fn effect_mm(&self, i: usize, effects: &[ResolvedEffect]) -> Vector3<f64> {
        let at = self.at(i);
        self.shown_mm(&effects.iter().map(|effect| effect.displaced(&at)).sum())
    }
}

pub(crate) fn of_pose(readings: &Readings) -> Vec<Vec<usize>> {
    let mut of_pose = vec![Vec::new(); readings.steps.len()];
    for (i, reading) in readings.all.iter().enumerate() {
        if let Some(pose) = reading.pose {
            of_pose[pose].push(i);
        }
    }
    of_pose
}

/// The pose that fits its points best; if they do not determine it, it keeps its rotation.
fn fitted(
    pose: Isometry3<f64>,
    own: &[usize],
    readings: &Readings,
    shapes_mm: &[Point3<f64>],
) -> Isometry3<f64> {
    let of = |i: &usize| &readings.all[*i];
    let measured: Vec<Point3<f64>> = own.iter().map(|i| of(i).measured_mm).collect();
    let home: Vec<Point3<f64>> = own.iter().map(|i| shapes_mm[of(i).shape]).collect();
    if distinct(own.iter().map(|i| of(i).shape)).len() >= TARGETS_OF_A_POSE {
        return best_fit(&home, &measured);
    }
    let left = measured.iter().zip(&home).map(|(p, h)| p - pose * h);
    let mean = left.sum::<Vector3<f64>>() / own.len().max(1) as f64;
    Translation3::from(mean) * pose
}

/// Moves each shape to the mean of its points; returns the largest move, mm.
fn fit_shapes(
    shapes_mm: &mut [Point3<f64>],
    readings: &Readings,
    poses: &[Isometry3<f64>],
    still: &Isometry3<f64>,
) -> f64 {
    let mut sums = vec![(0.0, Vector3::zeros()); shapes_mm.len()];
    for reading in &readings.all {
        let pose = reading.pose.map_or(still, |pose| &poses[pose]);
        let sum = &mut sums[reading.shape];
        sum.0 += 1.0;
        sum.1 += (pose.inverse() * reading.measured_mm).coords;
    }
    let mut largest_mm = 0.0_f64;
    for (shape, (count, sum)) in shapes_mm.iter_mut().zip(sums) {
        let mean = Point3::from(sum / count);
        largest_mm = largest_mm.max((mean - *shape).amax());
        *shape = mean;
    }
    largest_mm
}

/// The pivot of a pose, and the distance of its points from it, mm.
struct Arm {
    pivot_mm: Point3<f64>,
    length_mm: f64,
}

impl Arm {
    fn of(own: &[usize], modelled: &[Point3<f64>]) -> Self {
        let count = own.len().max(1) as f64;
        let sum: Vector3<f64> = own.iter().map(|&i| modelled[i].coords).sum();
        let pivot_mm = Point3::from(sum / count);
        let squares = own.iter().map(|&i| (modelled[i] - pivot_mm).norm_squared());
        let length_mm = (squares.sum::<f64>() / count).sqrt();
        Self {
            pivot_mm,
            length_mm,
        }
    }
}

fn by_pose(readings: &Readings, modelled: &[Point3<f64>], arms: &[Arm]) -> Vec<Matrix3x6<f64>> {
    let of_point = |(reading, p): (&Reading, &Point3<f64>)| {
        let mut by = Matrix3x6::zeros();
        if let Some(arm) = reading.pose.map(|pose| &arms[pose]) {
            by.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
            let turned = -(p - arm.pivot_mm).cross_matrix() / arm.length_mm.max(1.0);
            by.fixed_view_mut::<3, 3>(0, 3).copy_from(&turned);
        }
        by
    };
    readings.all.iter().zip(modelled).map(of_point).collect()
}

/// Position of each point in the datum, and the centroid of the targets at its step.
fn places_mm(
    readings: &Readings,
    modelled: &[Point3<f64>],
    instrument_from_datum: &Isometry3<f64>,
) -> Vec<[Point3<f64>; 2]> {
    let datum = |p: &Point3<f64>| instrument_from_datum.inverse() * p;
    let mut centroids = vec![Point3::origin(); modelled.len()];
    for own in of_pose(readings) {
        let mut targets: Vec<(usize, usize)> =
            own.iter().map(|&i| (readings.all[i].shape, i)).collect();
        targets.sort_unstable();
        targets.dedup_by_key(|(shape, _)| *shape);
        let sum: Vector3<f64> = targets.iter().map(|(_, i)| modelled[*i].coords).sum();
        let centroid = datum(&Point3::from(sum / targets.len().max(1) as f64));
        own.iter().for_each(|&i| centroids[i] = centroid);
    }
    let places = modelled.iter().zip(centroids);
    places.map(|(p, centroid)| [datum(p), centroid]).collect()
}
