//! A network in which nothing is regular: what is computed for several groups at a time must serve each.

use std::sync::Arc;

use nalgebra::{Point3, Translation3, Vector3};
use trueaxis_multilateration::{
    Bodies, Body, Interruption, KnownDeadPath, Network, Noise, Placed, Reading, Reflectors, Visit,
};

use crate::world::{STATIONS, TARGETS};

/// What all reflectors add to the dead paths, mm.
const DEAD_PATH_MM: f64 = 50.0;

/// Groups of three or two points 20 µm off nominal. Every station visits the groups twice, forward and backward, with the
/// targets in changing order and some of them left out; the beam of one is interrupted within a visit, some lengths count
/// less, each target has a reflector of its own. Groups of three may be tied.
pub(crate) fn network(groups: usize, noise: Noise, is_tied: bool) -> Network {
    let mut bodies = Bodies::default();
    bodies.bodies.push(Body {
        home_mm: TARGETS.map(Point3::from).to_vec(),
    });
    let mut network = Network {
        stations: vec![None; STATIONS.len()],
        noise,
        ..Network::default()
    };
    for group in 0..groups {
        let place = |irrational: f64| (group as f64 * irrational).fract() * 400.0;
        let shift = Vector3::new(place(0.754_878), place(0.569_84), place(0.438_579));
        let first = network.nominal_mm.len();
        let seen = 3 - usize::from(group % 4 == 1);
        let places = TARGETS[..seen].iter().map(|t| Point3::from(*t) + shift);
        network.nominal_mm.extend(places);
        network.groups.push(first..first + seen);
        bodies.of_groups.push(Placed {
            body: (seen == 3).then_some(0),
            places: if seen == 3 { vec![0, 1, 2] } else { Vec::new() },
            ref_from_home: Translation3::from(shift).into(),
        });
    }
    network.bodies = is_tied.then(|| Arc::new(bodies));
    network.reflectors = Some(Arc::new(Reflectors {
        count: 3,
        sigma_mm: None,
        of_points: network.groups.iter().flat_map(|g| 0..g.len()).collect(),
    }));
    for (station, (position, _)) in STATIONS.iter().enumerate() {
        for turn in 0..2 * groups {
            let group = turn.min(2 * groups - 1 - turn);
            let points = network.groups[group].clone();
            let first = network.readings.len();
            for k in (0..points.len()).filter(|k| (turn + station) % 11 != *k) {
                let point = (k + turn) % points.len();
                let place =
                    network.nominal_mm[points.start + point].map(|x| x + 0.02 * (0.37 * x).sin());
                let length_mm = (place - Point3::from(*position)).norm() - DEAD_PATH_MM;
                network.readings.push(Reading { point, length_mm });
            }
            network.visits.push(Visit {
                station,
                group,
                readings: first..network.readings.len(),
            });
        }
    }
    let factor = |i: usize| if i % 17 == 3 { 9.0 } else { 1.0 };
    network.variance_factors = (0..network.readings.len()).map(factor).collect();
    let interrupted = &network.visits[2 * (2 * groups) + 20];
    network.interruptions.push(Interruption {
        station: interrupted.station,
        first_reading: interrupted.readings.start + 1,
    });
    network
}

/// The dead paths of three stations are known, too.
pub(crate) fn with_dead_paths(mut network: Network) -> Network {
    let sigmas_mm = [0.02, 0.01, 0.03].into_iter().enumerate();
    let known = sigmas_mm.map(|(station, sigma_mm)| KnownDeadPath {
        station,
        length_mm: DEAD_PATH_MM + 0.01,
        sigma_mm,
    });
    network.dead_paths = known.collect();
    network
}

/// The dead path that each reading is taken with: of its station, and after the interruption another one.
pub(crate) fn dead_path_of_readings(network: &Network) -> Vec<usize> {
    let mut dead_paths = Vec::new();
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            let after = network.interruptions.iter().rposition(|interruption| {
                interruption.station == visit.station && interruption.first_reading <= reading
            });
            dead_paths.push(after.map_or(visit.station, |k| network.stations.len() + k));
        }
    }
    dead_paths
}
