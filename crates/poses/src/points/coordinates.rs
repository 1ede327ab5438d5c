//! From measured coordinates to points: repeats averaged, moved into the datum.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, Matrix2, Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Points};
use trueaxis_kinematics::{Ideal, MICROMETRE, best_fit};

use crate::points::{GroupReading, MeasuredPoints, PointGroup, PointNoise};

/// Standard deviation of a coordinate where none is declared: it only makes weights equal.
const UNDECLARED_SIGMA_MM: f64 = 1e-3;

/// One target's readings at one step.
#[derive(Default)]
struct Sample {
    readings: Vec<SampleReading>,
}

struct SampleReading {
    reading: usize,
    visit: usize,
    /// 1/mm².
    weight: f64,
    position_mm: Vector3<f64>,
}

impl Sample {
    fn weight(&self) -> f64 {
        self.readings.iter().map(|r| r.weight).sum()
    }

    fn mean(&self) -> Vector3<f64> {
        let places = self.readings.iter().map(|r| r.position_mm * r.weight);
        places.sum::<Vector3<f64>>() / self.weight()
    }

    /// The readings of the target at `place`, relative to their mean; both are in the instrument's frame.
    fn off_mean(&self, place: usize, repeatability_variance_mm2: f64) -> Vec<GroupReading> {
        let (mean, sum) = (self.mean(), self.weight());
        let reading = |r: &SampleReading| GroupReading {
            reading: r.reading,
            visit: r.visit,
            place,
            weight: r.weight,
            share: r.weight / sum,
            variance_mm2: 1.0 / r.weight + repeatability_variance_mm2,
            off_mean_mm: r.position_mm - mean,
        };
        self.readings.iter().map(reading).collect()
    }
}

/// The averaged points in the datum. Readings of one visit share an error of this repeatability.
pub(crate) fn points_from_coordinates(
    campaign: &Campaign,
    points: &Points,
    by_direction: bool,
    repeatability_mm: f64,
) -> MeasuredPoints {
    let repeatability_variance_mm2 = repeatability_mm * repeatability_mm;
    let mut nominal_mm: Vec<Point3<f64>> = Vec::new();
    let mut noise = PointNoise::default();
    let mut instrument = PointNoise::default();
    let mut groups: Vec<PointGroup> = Vec::new();
    let mut readings: Vec<Vec<GroupReading>> = Vec::new();
    let all = samples_of_steps(points, by_direction).into_iter();
    // Targets on the bed have no pose and no repeatability, and their campaign positions are only rough.
    let in_runs = all.filter(|(step, ..)| campaign.steps[*step].run.is_some());
    for (step, direction, samples) in in_runs {
        let positions = &campaign.steps[step].positions;
        let mut of_group = Vec::new();
        for (place, (&target, sample)) in samples.iter().enumerate() {
            let target = &campaign.targets[target];
            let position =
                campaign
                    .machine
                    .position(&Ideal, target.carrier, positions, target.home_mm);
            nominal_mm.push(position);
            of_group.extend(sample.off_mean(place, repeatability_variance_mm2));
        }
        readings.push(of_group);
        let all: Vec<&Sample> = samples.values().collect();
        for (noise, variance_mm2) in [
            (&mut noise, repeatability_variance_mm2),
            (&mut instrument, 0.0),
        ] {
            // The variance is equal in all directions, so rotating into the datum does not change it.
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
    for reading in readings.iter_mut().flatten() {
        reading.off_mean_mm = datum_from_instrument * reading.off_mean_mm;
    }
    if let Some(scale_ppm) = campaign.instrument.scale_sigma_ppm {
        noise.take_scale(&groups, scale_ppm * 1e-6);
    }
    MeasuredPoints {
        groups,
        noise,
        instrument,
        relative_covariance: Matrix2::zeros(),
        readings,
        repeatability_variance_mm2,
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

/// A step, its side of approach if the sides are kept apart, and the readings of its targets.
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
        for number_of_reading in stop.readings.clone() {
            let reading = &points.readings[number_of_reading];
            let declared_mm = reading.sigma_um.map(|um| um * MICROMETRE);
            let sigma_mm = declared_mm.unwrap_or(UNDECLARED_SIGMA_MM);
            let sample = steps[number].2.entry(reading.target).or_default();
            sample.readings.push(SampleReading {
                reading: number_of_reading,
                visit,
                weight: sigma_mm.powi(-2),
                position_mm: reading.position_mm.coords,
            });
        }
    }
    steps
}

/// Covariance of the means: each one's own noise, and the repeatability errors of common visits.
fn covariance(samples: &[&Sample], repeatability_variance_mm2: f64) -> DMatrix<f64> {
    let common = |a: &Sample, b: &Sample| {
        let mut sum = 0.0;
        for of_a in &a.readings {
            for of_b in b.readings.iter().filter(|of_b| of_b.visit == of_a.visit) {
                sum += of_a.weight * of_b.weight;
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
