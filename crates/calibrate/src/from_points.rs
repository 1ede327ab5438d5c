//! Measured coordinates to points: repeats averaged, brought into the datum.

use std::collections::HashMap;

use nalgebra::{DMatrix, Point3, Vector3};
use trueaxis_campaign::{Campaign, Points};
use trueaxis_kinematics::{Ideal, MICROMETRE};

use crate::measured::{Measured, MeasuredGroup, NoiseSource, PointNoise};
use crate::rigid_fit::rigid_fit;

/// Standard deviation of a coordinate where none is declared: the scatter then decides.
const UNDECLARED_SIGMA_MM: f64 = 1e-3;

/// Weighted mean of one target's readings at one step.
#[derive(Clone, Copy)]
struct Mean {
    target: usize,
    sum: Vector3<f64>,
    weight: f64,
}

/// The averaged points in the datum. Readings of one visit share the machine's return error.
pub(crate) fn measure(campaign: &Campaign, points: &Points, by_direction: bool) -> Measured {
    let mut number_of = HashMap::new();
    let mut groups: Vec<(MeasuredGroup, Vec<Mean>, usize)> = Vec::new();
    for stop in &points.stops {
        let direction = by_direction.then_some(stop.direction);
        let number = *number_of.entry((stop.step, direction)).or_insert_with(|| {
            let group = MeasuredGroup {
                step: stop.step,
                direction,
                targets: Vec::new(),
                points: 0..0,
            };
            groups.push((group, Vec::new(), 0));
            groups.len() - 1
        });
        let (_, means, visits) = &mut groups[number];
        *visits += 1;
        for reading in &points.readings[stop.readings.clone()] {
            let sigma_mm = reading
                .sigma_um
                .map_or(UNDECLARED_SIGMA_MM, |um| um * MICROMETRE);
            let weight = sigma_mm.powi(-2);
            let place = means.partition_point(|mean| mean.target < reading.target);
            if means
                .get(place)
                .is_none_or(|mean| mean.target != reading.target)
            {
                let empty = Mean {
                    target: reading.target,
                    sum: Vector3::zeros(),
                    weight: 0.0,
                };
                means.insert(place, empty);
            }
            means[place].sum += reading.position_mm.coords * weight;
            means[place].weight += weight;
        }
    }

    let return_sigma_mm = campaign.instrument.repeatability_um.unwrap_or(0.0) * MICROMETRE;
    let mut measured = Vec::new();
    let mut nominal: Vec<Point3<f64>> = Vec::new();
    let mut found: Vec<Point3<f64>> = Vec::new();
    let mut covariances = Vec::new();
    for (mut group, means, visits) in groups {
        let first = found.len();
        let positions = &campaign.steps[group.step].positions;
        for mean in &means {
            let target = &campaign.targets[mean.target];
            found.push(Point3::from(mean.sum / mean.weight));
            nominal.push(campaign.machine.position(
                &Ideal,
                target.carrier,
                positions,
                target.home_mm,
            ));
            group.targets.push(mean.target);
        }
        group.points = first..found.len();
        let shared = return_sigma_mm.powi(2) / visits as f64;
        covariances.push(covariance(&means, shared));
        measured.push(group);
    }
    let datum_from_instrument = rigid_fit(&found, &nominal);
    Measured {
        groups: measured,
        points_mm: found.iter().map(|p| datum_from_instrument * p).collect(),
        noise: PointNoise {
            // Equal in all directions, so that the datum's rotation does not change it.
            source: NoiseSource::Independent(covariances),
            variance_factor: 1.0,
        },
    }
}

fn covariance(means: &[Mean], shared: f64) -> DMatrix<f64> {
    DMatrix::from_fn(3 * means.len(), 3 * means.len(), |i, j| {
        let own = if i == j {
            1.0 / means[i / 3].weight
        } else {
            0.0
        };
        own + if i % 3 == j % 3 { shared } else { 0.0 }
    })
}
