use nalgebra::Point3;
use trueaxis_leastsquares::{Adjusted, Covariance, Error as LeastSquaresError, adjust};

use super::*;
use crate::{Network, Noise, Reading, Visit};

const STATIONS_MM: [[f64; 3]; 5] = [
    [1500.0, 300.0, 900.0],
    [-600.0, 1600.0, 100.0],
    [-700.0, -700.0, 700.0],
    [900.0, 900.0, 1900.0],
    [1200.0, -800.0, -200.0],
];

/// More than two pieces, the last of which does not fill its registers.
const POINTS: usize = 1229;

/// Single points all over a cube, with lengths some µm off; one station does not see every point.
fn network() -> Network {
    let mut network = Network {
        stations: vec![None; STATIONS_MM.len()],
        noise: Noise {
            length_sigma_mm: 3e-4,
            length_sigma_relative: 5e-7,
            ..Noise::default()
        },
        ..Network::default()
    };
    for i in 0..POINTS {
        // Weyl sequences: even, and never the same twice.
        let place = |irrational: f64| (i as f64 * irrational).fract() * 600.0;
        let p = Point3::new(place(0.7548), place(0.5698), place(0.4385));
        network.nominal_mm.push(p);
        network.groups.push(i..i + 1);
    }
    for (station, position) in STATIONS_MM.iter().enumerate() {
        for (group, p) in network.nominal_mm.iter().enumerate() {
            if station == 4 && group % 7 == 3 {
                continue;
            }
            let error_mm = ((7 * group + 3 * station) % 11) as f64 * 1e-3;
            let next = network.readings.len();
            network.readings.push(Reading {
                point: 0,
                length_mm: (p - Point3::from(*position)).norm() + error_mm,
            });
            let readings = next..next + 1;
            network.visits.push(Visit {
                station,
                group,
                readings,
            });
        }
    }
    network
}

fn start(network: &Network) -> State {
    let off = |p: &[f64; 3]| Point3::new(p[0] + 4.0, p[1] - 3.0, p[2] + 2.0);
    State {
        stations: STATIONS_MM.iter().map(off).collect(),
        dead_paths_mm: vec![1.0; STATIONS_MM.len()],
        points: network.nominal_mm.clone(),
    }
}

fn adjusted(model: &FreePoints<'_>, start: State) -> (Adjusted<State>, Covariance) {
    let adjusted = adjust(model, start, &Default::default()).unwrap();
    assert!(adjusted.termination.is_converged());
    let covariance = adjusted.covariance(model).unwrap();
    (adjusted, covariance)
}

fn assert_same(one: &(Adjusted<State>, Covariance), other: &(Adjusted<State>, Covariance)) {
    let (a, b) = (&one.0, &other.0);
    assert_eq!((a.observations, a.unknowns), (b.observations, b.unknowns));
    assert!((a.squares - b.squares).abs() < 1e-9 * a.squares);
    for (p, q) in a.state.points.iter().zip(&b.state.points) {
        // Distances are good to 1e-13 of some metres.
        assert!((p - q).norm() < 1e-9, "{p} {q}");
    }
    for i in 0..one.1.blocks() {
        let (c, d) = (one.1.block(i), other.1.block(i));
        let size = c.norm_max();
        assert!((&c - &d).norm_max() < 1e-8 * size, "point {i}");
        assert!(
            (one.1.inverse_factor(i) - other.1.inverse_factor(i)).norm_max() < 1e-8 * size.sqrt()
        );
    }
}

#[test]
fn lanes_and_groups_agree() {
    let network = network();
    let start = start(&network);
    let lanes = FreePoints::new(&network, &start);
    assert!(lanes.single().is_some());
    let groups = FreePoints::new(&network, &start).without_lanes();
    assert_same(&adjusted(&lanes, start.clone()), &adjusted(&groups, start));
}

/// Normal equations hand such a point to reflections; lanes orthonormalise it twice.
#[test]
fn beams_nearly_in_a_plane_agree() {
    let mut network = network();
    // Three beams to this point, from stations whose plane it is above by the given part of a metre.
    let [a, b, c] = [0, 1, 2].map(|j| Point3::from(STATIONS_MM[j]));
    let normal = (b - a).cross(&(c - a)).normalize();
    let centre = Point3::from((a.coords + b.coords + c.coords) / 3.0);
    let all = network.readings.clone();
    let mut place = |height_mm: f64| {
        network.nominal_mm[100] = centre + normal * height_mm;
        for visit in &network.visits {
            let reading = visit.readings.start;
            if visit.group == 100 {
                let p = network.nominal_mm[100] - Point3::from(STATIONS_MM[visit.station]);
                network.readings[reading].length_mm = p.norm() + 1e-3;
            } else {
                network.readings[reading] = all[reading];
            }
        }
        let mut seen = network.clone();
        let out = |visit: &Visit| visit.group == 100 && visit.station > 2;
        let removed: Vec<usize> = network
            .visits
            .iter()
            .filter(|visit| out(visit))
            .map(|visit| visit.readings.start)
            .collect();
        seen = seen.without(&removed).0;
        seen.visits.retain(|visit| !visit.readings.is_empty());
        seen
    };
    for height_mm in [100.0, 1.0, 0.1] {
        let network = place(height_mm);
        // Near the minimum, where corrections decide on the result: those of some mm, which the next
        // iteration corrects, are good to 1e-9 of themselves.
        let mut start = start(&network);
        for (station, truth) in start.stations.iter_mut().zip(STATIONS_MM) {
            *station = Point3::from(truth);
        }
        start.dead_paths_mm.fill(0.0);
        let lanes = FreePoints::new(&network, &start);
        let groups = FreePoints::new(&network, &start).without_lanes();
        let [s, t] = [&lanes, &groups].map(|model| {
            let reduced = model.reduce(&start).unwrap();
            let solution = reduced.solve(|| model.free_motions(&start)).unwrap();
            let mut next = start.clone();
            let t = &solution.unknowns;
            model.step(&start, t, 1.0, &mut next).unwrap();
            next
        });
        for (p, q) in s.stations.iter().zip(&t.stations) {
            assert!((p - q).norm() < 1e-9, "{height_mm} mm: {p} {q}");
        }
        for (i, (p, q)) in s.points.iter().zip(&t.points).enumerate() {
            // Across the plane, distances of 1.2 m, good to 1e-12 mm, are all that is known.
            let across_mm = 1200.0 / height_mm * 2e-12;
            let tol = if i == 100 { across_mm.max(1e-9) } else { 1e-9 };
            assert!((p - q).norm() < tol, "{height_mm} mm, point {i}: {p} {q}");
        }
    }
    // The stations of the start are elsewhere: put the point in their plane.
    let mut flat = place(0.0);
    let start = start(&flat);
    let [a, b, c] = [0, 1, 2].map(|j| start.stations[j].coords);
    flat.nominal_mm[100] = Point3::from((a + b + c) / 3.0);
    let mut start = start;
    start.points = flat.nominal_mm.clone();
    for model in [
        FreePoints::new(&flat, &start),
        FreePoints::new(&flat, &start).without_lanes(),
    ] {
        let error = model.reduce(&start).unwrap_err();
        let named = matches!(error, LeastSquaresError::BlockRank { block: 100, .. });
        assert!(named, "{error}");
    }
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let network = network();
    let start = start(&network);
    let bits = |threads: usize, lanes: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let mut model = FreePoints::new(&network, &start);
            if !lanes {
                model = model.without_lanes();
            }
            let (adjusted, covariance) = adjusted(&model, start.clone());
            let points = adjusted.state.points.iter().flat_map(|p| p.iter().copied());
            let blocks = (0..POINTS).map(|i| covariance.block(i)[(0, 0)]);
            points.chain(blocks).map(f64::to_bits).collect::<Vec<_>>()
        })
    };
    for lanes in [true, false] {
        let one = bits(1, lanes);
        assert!(one == bits(2, lanes) && one == bits(5, lanes));
    }
}
