//! Known stations and points, and lengths by plain arithmetic.

use std::sync::Arc;

use nalgebra::{Point3, Translation3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trueaxis_multilateration::{Bodies, Body, Network, Noise, Placed, Reading, Visit};

pub(crate) const TARGETS: [[f64; 3]; 3] = [
    [16.338, 452.716, 122.416],
    [157.086, 332.593, 324.879],
    [248.925, 603.0552, 412.4483],
];

pub(crate) const STATIONS: [([f64; 3], f64); 4] = [
    ([1500.0, 300.0, 900.0], 12.0),
    ([-600.0, 1600.0, 100.0], 345.0),
    ([-700.0, -700.0, 700.0], 678.0),
    ([900.0, 900.0, 1900.0], 91.0),
];

/// The paper's three-axis geometry: groups of three points at every step of three runs.
pub(crate) fn steps(step_mm: f64) -> Vec<[Point3<f64>; 3]> {
    let mut steps = Vec::new();
    for (axis, stroke) in [440.0, 400.0, 400.0].into_iter().enumerate() {
        let mut q = 0.0;
        while q <= stroke {
            steps.push(TARGETS.map(|t| Point3::from(t) + Vector3::ith(axis, q)));
            q += step_mm;
        }
    }
    steps
}

pub(crate) struct Truth {
    pub(crate) stations: Vec<(Point3<f64>, f64)>,
    pub(crate) points: Vec<Point3<f64>>,
}

pub(crate) fn truth(step_mm: f64) -> Truth {
    Truth {
        stations: STATIONS.map(|(s, l)| (Point3::from(s), l)).to_vec(),
        points: steps(step_mm).concat(),
    }
}

/// Exact lengths, `repeats` visits to every group from every station.
pub(crate) fn network(
    truth: &Truth,
    nominal: Vec<Point3<f64>>,
    repeats: usize,
    noise: Noise,
) -> Network {
    let groups: Vec<_> = (0..truth.points.len() / 3)
        .map(|g| 3 * g..3 * g + 3)
        .collect();
    let mut network = Network {
        stations: vec![None; truth.stations.len()],
        nominal_mm: nominal,
        groups,
        noise,
        ..Network::default()
    };
    for (station, (position, dead_path)) in truth.stations.iter().enumerate() {
        for _ in 0..repeats {
            for group in 0..network.groups.len() {
                let first = network.readings.len();
                for point in 0..3 {
                    let p = truth.points[3 * group + point];
                    let length_mm = (p - position).norm() - dead_path;
                    network.readings.push(Reading { point, length_mm });
                }
                network.visits.push(Visit {
                    station,
                    group,
                    readings: first..first + 3,
                });
            }
        }
    }
    network
}

pub(crate) fn add_noise(network: &mut Network, truth: &Truth, rng: &mut ChaCha8Rng) {
    let noise = network.noise;
    let mut normal = || -> f64 { rng.sample(StandardNormal) };
    for visit in &network.visits {
        let shift = Vector3::new(normal(), normal(), normal()) * noise.repeatability_mm;
        for reading in &mut network.readings[visit.readings.clone()] {
            let p = truth.points[3 * visit.group + reading.point];
            let (position, dead_path) = truth.stations[visit.station];
            let distance_mm = (p + shift - position).norm();
            let error_mm = normal() * noise.length_sigma_at_mm(distance_mm);
            reading.length_mm = distance_mm - dead_path + error_mm;
        }
    }
}

/// Ties the targets of every step to one body, whose shape is common to all.
pub(crate) fn tied(network: &Network) -> Network {
    let home_mm = TARGETS.map(Point3::from).to_vec();
    let placed = |group: &std::ops::Range<usize>| Placed {
        body: Some(0),
        places: vec![0, 1, 2],
        ref_from_home: Translation3::from(network.nominal_mm[group.start] - home_mm[0]).into(),
    };
    let bodies = Bodies {
        of_groups: network.groups.iter().map(placed).collect(),
        bodies: vec![Body {
            home_mm: home_mm.clone(),
        }],
    };
    Network {
        bodies: Some(Arc::new(bodies)),
        ..network.clone()
    }
}
