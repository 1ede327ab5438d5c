//! Inputs of the benchmarks.

use nalgebra::{Point3, Vector3};
use trueaxis_multilateration::{Network, Noise, Reading, Station, Visit};
use trueaxis_simulate::Scenario;

/// The targets of the paper's three-axis machine, mm.
pub const TARGETS_MM: [[f64; 3]; 3] = [
    [16.338, 452.716, 122.416],
    [157.086, 332.593, 324.879],
    [248.925, 603.0552, 412.4483],
];

/// Where the tracker stands, and its dead paths, mm.
pub const STATIONS: [([f64; 3], f64); 8] = [
    ([1500.0, 300.0, 900.0], 12.0),
    ([-600.0, 1600.0, 100.0], 345.0),
    ([-700.0, -700.0, 700.0], 678.0),
    ([900.0, 900.0, 1900.0], 91.0),
    ([1700.0, 1500.0, 300.0], 234.0),
    ([-900.0, 400.0, 1600.0], 567.0),
    ([400.0, -1100.0, 100.0], 89.0),
    ([1300.0, -800.0, 1400.0], 410.0),
];

/// The scenario of the shipped three-axis campaign: 2,340 lengths in three repeats.
///
/// # Panics
/// If the file does not hold a scenario.
pub fn fxyz() -> Scenario {
    let text = include_str!("../../campaigns/fxyz/scenario.json");
    Scenario::from_json(text).expect("a scenario")
}

/// A network of `points` points (a multiple of three: the paper's targets at that many places of
/// its machine) seen once from each of four stations. The points are some 20 µm off nominal. With
/// `return_sigma_mm` above zero the three lengths of a visit correlate and the targets of a step
/// are one block of nine unknowns; with zero every point is a block of three.
pub fn network(points: usize, return_sigma_mm: f64) -> Network {
    network_from(4, points, return_sigma_mm)
}

/// As [`network`], from the first of [`STATIONS`].
///
/// # Panics
/// If there are not so many stations.
pub fn network_from(stations: usize, points: usize, return_sigma_mm: f64) -> Network {
    let stations = &STATIONS[..stations];
    let mut network = Network {
        stations: vec![None; stations.len()],
        noise: Noise {
            length_sigma_mm: 0.269e-3,
            return_sigma_mm,
            ..Noise::default()
        },
        ..Network::default()
    };
    let mut true_points = Vec::new();
    for step in 0..points / 3 {
        // Places that fill the volume evenly and differ from each other (Weyl sequence).
        let place = |irrational: f64| (step as f64 * irrational).fract() * 400.0;
        let shift = Vector3::new(
            place(0.754_877_666),
            place(0.569_840_291),
            place(0.438_579_021),
        );
        let deviation =
            Vector3::new(place(0.9), place(0.8), place(0.7)).map(|d| (d - 200.0) * 1e-4);
        for target in TARGETS_MM {
            let nominal = Point3::from(target) + shift;
            network.nominal_mm.push(nominal);
            true_points.push(nominal + deviation);
        }
    }
    let per_group = if return_sigma_mm > 0.0 { 3 } else { 1 };
    for first in (0..true_points.len()).step_by(per_group) {
        network.groups.push(first..first + per_group);
    }
    for (station, (position, dead_path)) in stations.iter().enumerate() {
        for (group, points) in network.groups.iter().enumerate() {
            let first = network.readings.len();
            for (point, p) in true_points[points.clone()].iter().enumerate() {
                let length_mm = (p - Point3::from(*position)).norm() - dead_path;
                network.readings.push(Reading { point, length_mm });
            }
            let readings = first..network.readings.len();
            network.visits.push(Visit {
                station,
                group,
                readings,
            });
        }
    }
    network
}

/// A start for networks of [`network_from`] whose points start at their nominal places: stations some
/// 5 mm off.
///
/// # Panics
/// If there are not so many stations.
pub fn stations_near(stations: usize) -> Vec<Station> {
    let off = Vector3::new(3.0, -3.0, 2.5);
    let signs = [1.0, -1.0].into_iter().cycle();
    let stations = STATIONS[..stations].iter().zip(signs);
    stations
        .map(|(&(position, dead_path_mm), sign)| Station {
            position_mm: Point3::from(position) + off * sign,
            dead_path_mm: dead_path_mm + 5.0 * sign,
        })
        .collect()
}
