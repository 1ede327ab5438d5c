//! Measured coordinates to points: repeats averaged, brought into the datum.

use std::collections::HashMap;

use nalgebra::{DMatrix, Matrix2, Point3, Vector3};
use trueaxis_campaign::{Campaign, Points};
use trueaxis_kinematics::{Ideal, MICROMETRE};

use crate::points::{MeasuredPoints, PointGroup, PointNoise};
use crate::rigid_fit::rigid_fit;

/// Standard deviation of a coordinate where none is declared: the scatter then decides.
const UNDECLARED_SIGMA_MM: f64 = 1e-3;

/// One target's readings at one step.
struct Sample {
    target: usize,
    /// Visit, weight (1/mm²) and position of each reading.
    readings: Vec<(usize, f64, Vector3<f64>)>,
}

impl Sample {
    fn weight(&self) -> f64 {
        self.readings.iter().map(|&(_, weight, _)| weight).sum()
    }

    fn mean(&self) -> Vector3<f64> {
        let sum: Vector3<f64> = self.readings.iter().map(|(_, weight, p)| p * *weight).sum();
        sum / self.weight()
    }

    /// Sum of squares of the scatter about the mean, in units of the declared variance, with its
    /// degrees of freedom.
    fn scatter(&self, return_variance_mm2: f64) -> (f64, usize) {
        let mean = self.mean();
        let square = |(_, weight, p): &(usize, f64, Vector3<f64>)| {
            (p - mean).norm_squared() / (1.0 / weight + return_variance_mm2)
        };
        (
            self.readings.iter().map(square).sum(),
            3 * (self.readings.len() - 1),
        )
    }
}

/// The averaged points in the datum. Readings of one visit share the machine's return error.
pub(crate) fn measure(campaign: &Campaign, points: &Points, by_direction: bool) -> MeasuredPoints {
    let mut number_of = HashMap::new();
    let mut groups: Vec<(PointGroup, Vec<Sample>)> = Vec::new();
    for (visit, stop) in points.stops.iter().enumerate() {
        let direction = by_direction.then_some(stop.direction);
        let number = *number_of.entry((stop.step, direction)).or_insert_with(|| {
            let group = PointGroup {
                step: stop.step,
                direction,
                targets: Vec::new(),
                points_mm: Vec::new(),
            };
            groups.push((group, Vec::new()));
            groups.len() - 1
        });
        let samples = &mut groups[number].1;
        for reading in &points.readings[stop.readings.clone()] {
            let sigma_mm = reading
                .sigma_um
                .map_or(UNDECLARED_SIGMA_MM, |um| um * MICROMETRE);
            let place = samples.partition_point(|sample| sample.target < reading.target);
            if samples
                .get(place)
                .is_none_or(|sample| sample.target != reading.target)
            {
                samples.insert(
                    place,
                    Sample {
                        target: reading.target,
                        readings: Vec::new(),
                    },
                );
            }
            let position = reading.position_mm.coords;
            samples[place]
                .readings
                .push((visit, sigma_mm.powi(-2), position));
        }
    }

    let return_sigma_mm = campaign.instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE;
    let return_variance_mm2 = return_sigma_mm * return_sigma_mm;
    let mut nominal: Vec<Point3<f64>> = Vec::new();
    let mut noise = PointNoise::default();
    let mut instrument = PointNoise::default();
    let mut repeat_scatter = (0.0, 0);
    let mut measured = Vec::new();
    for (mut group, samples) in groups {
        let positions = &campaign.steps[group.step].positions;
        for sample in &samples {
            let target = &campaign.targets[sample.target];
            group.points_mm.push(Point3::from(sample.mean()));
            nominal.push(campaign.machine.position(
                &Ideal,
                target.carrier,
                positions,
                target.home_mm,
            ));
            group.targets.push(sample.target);
            let (squares, degrees) = sample.scatter(return_variance_mm2);
            repeat_scatter = (repeat_scatter.0 + squares, repeat_scatter.1 + degrees);
        }
        for (noise, variance_mm2) in [(&mut noise, return_variance_mm2), (&mut instrument, 0.0)] {
            // Equal in all directions, so that the datum's rotation does not change it.
            noise.own.push(covariance(&samples, variance_mm2));
            noise.coupling.push(DMatrix::zeros(3 * samples.len(), 0));
        }
        measured.push(group);
    }
    let found: Vec<Point3<f64>> = measured.iter().flat_map(|g| g.points_mm.clone()).collect();
    let datum_from_instrument = rigid_fit(&found, &nominal);
    for point in measured.iter_mut().flat_map(|group| &mut group.points_mm) {
        *point = datum_from_instrument * *point;
    }
    MeasuredPoints {
        groups: measured,
        noise,
        instrument,
        relative_covariance: Matrix2::zeros(),
        repeat_scatter,
    }
}

/// Covariance of the means: each one's own noise, and the return errors of common visits.
fn covariance(samples: &[Sample], return_variance_mm2: f64) -> DMatrix<f64> {
    let common = |a: &Sample, b: &Sample| {
        let mut sum = 0.0;
        for (visit, weight_a, _) in &a.readings {
            for (_, weight_b, _) in b.readings.iter().filter(|(other, _, _)| other == visit) {
                sum += weight_a * weight_b;
            }
        }
        sum / (a.weight() * b.weight())
    };
    DMatrix::from_fn(3 * samples.len(), 3 * samples.len(), |i, j| {
        let (a, b) = (&samples[i / 3], &samples[j / 3]);
        let own = if i == j { 1.0 / a.weight() } else { 0.0 };
        own + if i % 3 == j % 3 {
            return_variance_mm2 * common(a, b)
        } else {
            0.0
        }
    })
}
