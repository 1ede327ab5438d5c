//! Measured coordinates to points: repeats averaged, brought into the datum.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, Matrix2, Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Points};
use trueaxis_kinematics::{Ideal, MICROMETRE, best_fit};

use crate::points::{MeasuredPoints, PointGroup, PointNoise};

/// Standard deviation of a coordinate where none is declared: the scatter then decides.
const UNDECLARED_SIGMA_MM: f64 = 1e-3;

/// One target's readings at one step.
#[derive(Default)]
struct Sample {
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
    fn scatter(&self, repeatability_variance_mm2: f64) -> (f64, usize) {
        let mean = self.mean();
        let square = |(_, weight, p): &(usize, f64, Vector3<f64>)| {
            (p - mean).norm_squared() / (1.0 / weight + repeatability_variance_mm2)
        };
        let squares = self.readings.iter().map(square).sum();
        (squares, 3 * (self.readings.len() - 1))
    }
}

/// The averaged points in the datum. Readings of one visit share the repeatability error.
pub(crate) fn points_from_coordinates(
    campaign: &Campaign,
    points: &Points,
    by_direction: bool,
) -> MeasuredPoints {
    let repeatability_mm = campaign.instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE;
    let repeatability_variance_mm2 = repeatability_mm * repeatability_mm;
    let mut nominal_mm: Vec<Point3<f64>> = Vec::new();
    let mut noise = PointNoise::default();
    let mut instrument = PointNoise::default();
    let mut repeat_scatter = (0.0, 0);
    let mut groups: Vec<PointGroup> = Vec::new();
    for (step, direction, samples) in samples_of_steps(points, by_direction) {
        let positions = &campaign.steps[step].positions;
        for (&target, sample) in &samples {
            let target = &campaign.targets[target];
            let position =
                campaign
                    .machine
                    .position(&Ideal, target.carrier, positions, target.home_mm);
            nominal_mm.push(position);
            let (squares, degrees) = sample.scatter(repeatability_variance_mm2);
            repeat_scatter = (repeat_scatter.0 + squares, repeat_scatter.1 + degrees);
        }
        let all: Vec<&Sample> = samples.values().collect();
        for (noise, variance_mm2) in [
            (&mut noise, repeatability_variance_mm2),
            (&mut instrument, 0.0),
        ] {
            // Equal in all directions, so that the datum's rotation does not change it.
            noise.own.push(covariance(&all, variance_mm2));
            noise.coupling.push(DMatrix::zeros(3 * samples.len(), 0));
        }
        groups.push(PointGroup {
            step,
            direction,
            targets: samples.keys().copied().collect(),
            points_mm: all
                .iter()
                .map(|sample| Point3::from(sample.mean()))
                .collect(),
        });
    }
    let found: Vec<Point3<f64>> = groups.iter().flat_map(|g| g.points_mm.clone()).collect();
    let datum_from_instrument = best_fit(&found, &nominal_mm);
    for point in groups.iter_mut().flat_map(|group| &mut group.points_mm) {
        *point = datum_from_instrument * *point;
    }
    if let Some(scale_ppm) = campaign.instrument.scale_sigma_ppm {
        noise.take_scale(&groups, scale_ppm * 1e-6);
    }
    MeasuredPoints {
        groups,
        noise,
        instrument,
        relative_covariance: Matrix2::zeros(),
        repeat_scatter,
    }
}

impl PointNoise {
    /// The scale of all coordinates together becomes a shared source.
    fn take_scale(&mut self, groups: &[PointGroup], sigma: f64) {
        for (coupling, group) in self.coupling.iter_mut().zip(groups) {
            let places = group.points_mm.iter().flat_map(|p| [p.x, p.y, p.z]);
            *coupling = DMatrix::from_iterator(3 * group.points_mm.len(), 1, places);
        }
        self.shared = DMatrix::from_element(1, 1, sigma * sigma);
        self.declared = self.shared.clone();
        self.stations = DMatrix::zeros(0, 1);
    }
}

/// A step, its side of approach where kept apart, and the readings of its targets.
type StepSamples = (usize, Option<Direction>, BTreeMap<usize, Sample>);

/// The steps in measuring order.
fn samples_of_steps(points: &Points, by_direction: bool) -> Vec<StepSamples> {
    let mut number_of = HashMap::new();
    let mut steps: Vec<StepSamples> = Vec::new();
    for (visit, stop) in points.stops.iter().enumerate() {
        let direction = by_direction.then_some(stop.direction);
        let number = *number_of.entry((stop.step, direction)).or_insert_with(|| {
            steps.push((stop.step, direction, BTreeMap::new()));
            steps.len() - 1
        });
        for reading in &points.readings[stop.readings.clone()] {
            let declared_mm = reading.sigma_um.map(|um| um * MICROMETRE);
            let sigma_mm = declared_mm.unwrap_or(UNDECLARED_SIGMA_MM);
            let position = (visit, sigma_mm.powi(-2), reading.position_mm.coords);
            let sample = steps[number].2.entry(reading.target).or_default();
            sample.readings.push(position);
        }
    }
    steps
}

/// Covariance of the means: each one's own noise, and the repeatability errors of common visits.
fn covariance(samples: &[&Sample], repeatability_variance_mm2: f64) -> DMatrix<f64> {
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
        let (a, b) = (samples[i / 3], samples[j / 3]);
        let own = if i == j { 1.0 / a.weight() } else { 0.0 };
        let of_repeatability = if i % 3 == j % 3 {
            repeatability_variance_mm2 * common(a, b)
        } else {
            0.0
        };
        own + of_repeatability
    })
}
