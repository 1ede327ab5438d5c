//! From measured coordinates to points: repeats averaged, moved into the datum.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{DMatrix, Matrix2, Matrix3, Point3, Vector3};
use trueaxis_campaign::{Campaign, Direction, Points};
use trueaxis_kinematics::{Ideal, MICROMETRE, best_fit};
use trueaxis_screening::CoordinateNoise;

use crate::points::{GroupReading, MeasuredPoints, PointGroup, PointNoise, UNDECLARED_SIGMA_UM};

/// One target's readings at one step.
#[derive(Default)]
struct Sample {
    readings: Vec<SampleReading>,
}

struct SampleReading {
    reading: usize,
    visit: usize,
    /// 1 over the declared variance, 1/mm².
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

    /// The readings of the target at `place`, whose noise has the covariance `relative` in units of the declared
    /// variance, relative to their mean.
    fn off_mean(
        &self,
        place: usize,
        relative: &Matrix3<f64>,
        datum_from_instrument: &Matrix3<f64>,
    ) -> Vec<GroupReading> {
        let (mean, sum) = (self.mean(), self.weight());
        let reading = |r: &SampleReading| GroupReading {
            reading: r.reading,
            visit: r.visit,
            place,
            own_mm2: relative / r.weight,
            share: r.weight / sum,
            off_mean_mm: datum_from_instrument * (r.position_mm - mean),
        };
        self.readings.iter().map(reading).collect()
    }
}

/// The averaged points in the datum, and the rotation into it from the instrument's frame. Their noise depends on place
/// and direction as `noise` says; readings of one visit share an error of this repeatability.
pub(crate) fn points_from_coordinates(
    campaign: &Campaign,
    points: &Points,
    by_direction: bool,
    (noise, repeatability_mm): (&CoordinateNoise, f64),
) -> (MeasuredPoints, Matrix3<f64>) {
    let all = samples_of_steps(points, by_direction).into_iter();
    // Targets on the bed have no pose and no repeatability, and their campaign positions are only rough.
    let in_runs = all.filter(|(step, ..)| campaign.steps[*step].run.is_some());
    let steps: Vec<StepSamples> = in_runs.collect();
    let (mut nominal_mm, mut found_mm) = (Vec::new(), Vec::new());
    for (step, _, samples) in &steps {
        for (&target, sample) in samples {
            let positions = &campaign.steps[*step].positions;
            let target = &campaign.targets[target];
            let machine = &campaign.machine;
            nominal_mm.push(machine.position(&Ideal, target.carrier, positions, target.home_mm));
            found_mm.push(Point3::from(sample.mean()));
        }
    }
    let datum_from_instrument = best_fit(&found_mm, &nominal_mm);
    let turn = datum_from_instrument.rotation.to_rotation_matrix();
    let turn = turn.into_inner();
    let variance_mm2 = repeatability_mm * repeatability_mm;
    let mut measured = MeasuredPoints {
        groups: Vec::new(),
        noise: PointNoise::default(),
        instrument: PointNoise::default(),
        relative_covariance: Matrix2::zeros(),
        readings: Vec::new(),
        repeatability_variance_mm2: variance_mm2,
    };
    for (step, direction, samples) in steps {
        let covariance = |sample: &Sample| {
            let in_instrument = noise.covariance(&Point3::from(sample.mean()));
            turn * in_instrument * turn.transpose()
        };
        let relative: Vec<Matrix3<f64>> = samples.values().map(covariance).collect();
        let of_place =
            |(place, sample): (usize, &Sample)| sample.off_mean(place, &relative[place], &turn);
        let readings: Vec<GroupReading> = samples.values().enumerate().flat_map(of_place).collect();
        for (noise, variance_mm2) in [
            (&mut measured.noise, variance_mm2),
            (&mut measured.instrument, 0.0),
        ] {
            noise
                .own
                .push(of_means(&readings, samples.len(), variance_mm2));
            noise.coupling.push(DMatrix::zeros(3 * samples.len(), 0));
        }
        measured.readings.push(readings);
        let mean = |sample: &Sample| datum_from_instrument * Point3::from(sample.mean());
        measured.groups.push(PointGroup {
            step,
            direction,
            targets: samples.keys().copied().collect(),
            points_mm: samples.values().map(mean).collect(),
        });
    }
    if let Some(scale_ppm) = campaign.instrument.scale_sigma_ppm {
        measured
            .noise
            .take_scale(&measured.groups, scale_ppm * 1e-6);
    }
    (measured, turn)
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
            let sigma_mm = reading.sigma_um.unwrap_or(UNDECLARED_SIGMA_UM) * MICROMETRE;
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
fn of_means(
    readings: &[GroupReading],
    places: usize,
    repeatability_variance_mm2: f64,
) -> DMatrix<f64> {
    let mut covariance = DMatrix::zeros(3 * places, 3 * places);
    for a in readings {
        let mut own = covariance.fixed_view_mut::<3, 3>(3 * a.place, 3 * a.place);
        own += a.own_mm2 * (a.share * a.share);
        for b in readings.iter().filter(|b| b.visit == a.visit) {
            let mut common = covariance.fixed_view_mut::<3, 3>(3 * a.place, 3 * b.place);
            common +=
                Matrix3::from_diagonal_element(repeatability_variance_mm2 * a.share * b.share);
        }
    }
    covariance
}
