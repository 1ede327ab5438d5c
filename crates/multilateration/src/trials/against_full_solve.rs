//! Trials against the full nonlinear adjustment of the same lengths.

#![expect(clippy::print_stdout, reason = "shows what each correction leaves")]

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_leastsquares::{Adjustment, Settings as Iteration, adjust};

use super::{Corrections, Trials};
use crate::adjustment::GroupAdjustment;
use crate::batches::batches;
use crate::bodies::{Bodies, Body, Placed};
use crate::state::{POSE, State};
use crate::{
    Interruption, KnownDeadPath, Network, Noise, Reading, Reflectors, Settings, Solution, Visit,
    solve,
};
use trueaxis_kinematics::centroid;

const STATIONS_MM: [[f64; 3]; 4] = [
    [1500.0, 300.0, 900.0],
    [-600.0, 1600.0, 100.0],
    [-700.0, -700.0, 700.0],
    [900.0, 900.0, 1900.0],
];

const TARGETS_MM: [[f64; 3]; 3] = [
    [16.0, 453.0, 122.0],
    [157.0, 333.0, 325.0],
    [249.0, 603.0, 412.0],
];

const STEPS: usize = 30;

const NOISE: Noise = Noise {
    length_sigma_mm: 3e-4,
    length_sigma_relative: 5e-7,
    repeatability_mm: 1e-3,
};

/// 30 groups of three or two points 20 µm off nominal. Every station visits the groups twice,
/// forward and backward, with the targets in changing order and some of them left out; the beam of
/// one is interrupted, some lengths count less. Nothing here is regular. Groups of three may be tied.
fn network(noise: Noise, is_tied: bool) -> Network {
    let mut bodies = Bodies::default();
    bodies.bodies.push(Body {
        home_mm: TARGETS_MM.map(Point3::from).to_vec(),
    });
    let mut network = Network {
        stations: vec![None; 4],
        noise,
        ..Network::default()
    };
    for step in 0..STEPS {
        let place = |irrational: f64| (step as f64 * irrational).fract() * 400.0;
        let shift = Vector3::new(place(0.754_878), place(0.569_84), place(0.438_579));
        let first = network.nominal_mm.len();
        for target in &TARGETS_MM[..3 - usize::from(step % 4 == 1)] {
            network.nominal_mm.push(Point3::from(*target) + shift);
        }
        network.groups.push(first..network.nominal_mm.len());
        let is_whole = network.nominal_mm.len() - first == 3;
        bodies.of_groups.push(Placed {
            body: is_whole.then_some(0),
            places: if is_whole { vec![0, 1, 2] } else { Vec::new() },
            ref_from_home: Translation3::from(shift).into(),
        });
    }
    network.bodies = is_tied.then(|| Arc::new(bodies));
    let of_points = network.groups.iter().flat_map(|group| 0..group.len());
    network.reflectors = Some(Arc::new(Reflectors {
        count: 3,
        sigma_mm: None,
        of_points: of_points.collect(),
    }));
    for (station, position_mm) in STATIONS_MM.iter().enumerate() {
        for turn in 0..2 * STEPS {
            let group = turn.min(2 * STEPS - 1 - turn);
            let points = network.groups[group].clone();
            let first = network.readings.len();
            for k in 0..points.len() {
                let point = (k + turn) % points.len();
                if (turn + station) % 11 == k {
                    continue;
                }
                let nominal = network.nominal_mm[points.start + point];
                let place = nominal.map(|x| x + 0.02 * (0.37 * x).sin());
                let length_mm = (place - Point3::from(*position_mm)).norm() - 50.0;
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
    network.dead_paths = [0, 1, 2]
        .map(|station| KnownDeadPath {
            station,
            length_mm: 50.01,
            sigma_mm: [0.02, 0.01, 0.03][station],
        })
        .to_vec();
    network.interruptions.push(Interruption {
        station: 2,
        first_reading: network.visits[2 * (2 * STEPS) + 20].readings.start,
    });
    network
}

/// The lengths that follow from the solution, plus errors, adjusted from where they would lie
/// without errors, with the weights of the solution.
fn full_solution(network: &Network, solution: &Solution, errors_mm: &[f64]) -> State {
    let (errors_mm, known_errors) = errors_mm.split_at(network.readings.len());
    let mut disturbed = network.clone();
    let residuals = solution.residuals_mm.iter();
    for (known, error) in disturbed.dead_paths.iter_mut().zip(known_errors) {
        let computed_mm = solution.stations[known.station].dead_path_mm;
        known.length_mm = computed_mm + solution.mean_constant_mm.unwrap() + error * known.sigma_mm;
    }
    for ((reading, error), residual) in disturbed.readings.iter_mut().zip(errors_mm).zip(residuals)
    {
        reading.length_mm += error - residual;
    }
    let state = solution.state();
    let batches = Arc::new(batches(&disturbed));
    let mut linearised = Vec::new();
    let of_solution = GroupAdjustment::new(network, &batches);
    of_solution.reduce(&state, &mut linearised).unwrap();
    let mut model = GroupAdjustment::new(&disturbed, &batches);
    model.held = linearised.pop().map(|piece| piece.weights);
    let adjusted = adjust(&model, state, &Iteration::default()).unwrap();
    assert!(adjusted.termination.is_converged());
    adjusted.state
}

/// The largest difference of any unknown, in units of its standard uncertainty.
fn largest_difference(
    network: &Network,
    corrections: &Corrections,
    full: &State,
    solution: &Solution,
) -> f64 {
    let base = solution.state();
    let mut largest = 0.0_f64;
    let mut compare = |difference_mm: f64, variance: f64| {
        assert!(difference_mm.is_finite());
        largest = largest.max(difference_mm.abs() / variance.sqrt());
    };
    for (group, points) in network.groups.iter().enumerate() {
        let covariance = solution.group_covariance(group);
        let before = &base.points[points.clone()];
        let expected: Vec<f64> = match network.body_of(group) {
            Some(_) => {
                let motion: Isometry3<f64> = full.poses[group] * base.poses[group].inverse();
                let centre = centroid(before);
                let shift = motion * centre - centre;
                [shift, motion.rotation.scaled_axis()]
                    .iter()
                    .flat_map(|v| v.iter().copied())
                    .collect()
            }
            None => {
                let moved = full.points[points.clone()].iter().zip(before);
                moved
                    .flat_map(|(a, b)| (a - b).iter().copied().collect::<Vec<_>>())
                    .collect()
            }
        };
        let found = corrections.group(group);
        for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
            compare(found - expected, covariance[(k, k)]);
        }
        for point in points.clone() {
            let moved = full.points[point] - base.points[point];
            compare(
                (corrections.point_mm(point) - moved).norm(),
                covariance[(0, 0)],
            );
        }
    }
    let shared = solution.covariance.shared();
    for station in 0..base.stations.len() {
        let difference =
            corrections.station_mm(station) - (full.stations[station] - base.stations[station]);
        for k in 0..3 {
            compare(difference[k], shared[(4 * station + k, 4 * station + k)]);
        }
    }
    for zero in 0..base.dead_paths_mm.len() {
        let column = if zero < 4 { 4 * zero + 3 } else { 12 + zero };
        let expected = full.dead_paths_mm[zero] - base.dead_paths_mm[zero];
        let found = corrections.dead_path_mm(zero);
        compare(found - expected, shared[(column, column)]);
    }
    let contrasts = shared.nrows() - network.contrasts();
    let mean = contrasts - 1;
    let expected = full.mean_constant_mm - base.mean_constant_mm;
    let found = corrections.shared_mm()[mean];
    compare(found - expected, shared[(mean, mean)]);
    for m in 0..network.contrasts() {
        let expected = full.contrasts_mm[m] - base.contrasts_mm[m];
        let found = corrections.shared_mm()[contrasts + m];
        compare(found - expected, shared[(contrasts + m, contrasts + m)]);
    }
    let bodies = network.bodies.iter().flat_map(|bodies| &bodies.bodies);
    for (b, body) in bodies.enumerate() {
        for (k, deformation) in body.deformations().iter().enumerate() {
            let places = full.shapes_mm[b].iter().zip(&base.shapes_mm[b]).enumerate();
            let expected: f64 = places
                .map(|(i, (a, b))| deformation.fixed_rows::<3>(3 * i).dot(&(a - b)))
                .sum();
            let column = mean - (3 * body.home_mm.len() - POSE) + k;
            let found = corrections.shared_mm()[column];
            compare(found - expected, shared[(column, column)]);
        }
    }
    largest
}

/// Largest differences of five trials: of the linear solution, after one more correction, of the
/// trial as it is solved. The errors are drawn, then made larger by `factor`.
fn differences(noise: Noise, is_tied: bool, factor: f64) -> [f64; 3] {
    let network = network(noise, is_tied);
    let solution = solve(&network, &Settings::default()).unwrap();
    assert!(solution.termination.is_converged());
    let trials = Trials::new(&network, &solution);
    let mut workspace = trials.workspace();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut errors_mm = vec![0.0; trials.errors()];
    let mut largest = [0.0_f64; 3];
    for _ in 0..5 {
        trials.draw(&mut rng, &mut errors_mm);
        errors_mm.iter_mut().for_each(|error| *error *= factor);
        let full = full_solution(&network, &solution, &errors_mm);
        trials.start(&errors_mm, &mut workspace);
        for largest in &mut largest[..2] {
            trials.correct(&mut workspace);
            trials.hand_out(&mut workspace);
            let corrections = &workspace.corrections;
            let difference = largest_difference(&network, corrections, &full, &solution);
            *largest = largest.max(difference);
        }
        let corrections = trials.solve(&errors_mm, &mut workspace);
        let difference = largest_difference(&network, corrections, &full, &solution);
        largest[2] = largest[2].max(difference);
    }
    let [linear, once, solved] = largest;
    println!(
        "errors x {factor}: linear {linear:.1e} u, corrected once {once:.1e} u, solved {solved:.1e} u"
    );
    largest
}

#[test]
fn trials_are_the_full_solution() {
    let exact_return = Noise {
        repeatability_mm: 0.0,
        ..NOISE
    };
    for (noise, is_tied) in [(NOISE, false), (exact_return, false), (NOISE, true)] {
        let [linear, _, solved] = differences(noise, is_tied, 1.0);
        assert!(linear < 1e-3 && solved < 1e-6);
        // Second-order effects grow with the errors; there are more corrections then.
        let [linear, once, solved] = differences(noise, is_tied, 10.0);
        assert!(linear > 1e-3 && once > 1e-6 && solved < 1e-6);
    }
}
