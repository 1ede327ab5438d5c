//! What is made of the hat matrix eight groups at a time, against its definition.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_leastsquares::dot;

use crate::baarda::test_all;
use crate::batch_influence::BatchInfluence;
use crate::bodies::{Bodies, Body, Placed};
use crate::step_tests::largest_steps;
use crate::whitened::Whitened;
use crate::{Interruption, Network, Noise, Reading, Settings, Solution, Visit, solve};

/// Of the small network, and of one that several pieces are made of.
const GROUPS: usize = 21;
const MANY_GROUPS: usize = 600;
const STATIONS: usize = 5;

fn wave(i: usize, k: f64) -> f64 {
    (k * (i as f64 + 0.7)).sin()
}

fn place(i: usize, size: f64) -> Point3<f64> {
    Point3::new(wave(i, 1.3), wave(i, 2.9), wave(i, 4.7)) * size
}

/// Groups of three points of a body (the last of two, which are free) with some readings missing, one of
/// them of little weight, an interruption in the middle of a visit, and errors of micrometres.
fn solved(groups: usize, repeatability_mm: f64, is_tied: bool) -> (Network, Solution) {
    let body = Body {
        home_mm: (0..3).map(|i| place(i, 150.0)).collect(),
    };
    let mut bodies = Bodies::default();
    let mut network = Network {
        stations: (0..STATIONS).map(|j| Some(place(j + 20, 2000.0))).collect(),
        noise: Noise {
            length_sigma_relative: 5e-7,
            repeatability_mm,
            ..Noise::default()
        },
        ..Network::default()
    };
    for group in 0..groups {
        let first = 3 * group;
        let points = if group + 1 < groups { 3 } else { 2 };
        network.groups.push(first..first + points);
        let pose = Isometry3::new(place(group + 5, 400.0).coords, place(group + 9, 1.0).coords);
        let places = body.home_mm[..points].iter().map(|p| pose * p);
        network.nominal_mm.extend(places);
        bodies.of_groups.push(Placed {
            body: (points == 3).then_some(0),
            places: if points == 3 {
                vec![0, 1, 2]
            } else {
                Vec::new()
            },
            ref_from_home: pose,
        });
    }
    bodies.bodies.push(body);
    network.bodies = is_tied.then(|| Arc::new(bodies));
    for station in 0..STATIONS {
        for group in 0..groups {
            let first = network.readings.len();
            for point in network.groups[group].clone() {
                if (point + 2 * station) % 11 == 4 {
                    continue;
                }
                let from = place(station + 20, 2000.0) + Vector3::repeat(wave(station, 5.1));
                let distance_mm = (network.nominal_mm[point] - from).norm();
                network.readings.push(Reading {
                    point: point - 3 * group,
                    length_mm: distance_mm + 2e-3 * wave(network.readings.len(), 3.3),
                });
            }
            network.visits.push(Visit {
                station,
                group,
                readings: first..network.readings.len(),
            });
        }
    }
    network.variance_factors = vec![1.0; network.readings.len()];
    network.variance_factors[17] = 50.0;
    let within = &network.visits[groups + 9];
    network.interruptions.push(Interruption {
        station: within.station,
        first_reading: within.readings.start + 1,
    });
    let solution = solve(&network, &Settings::default()).unwrap();
    (network, solution)
}

/// At the minimum the residuals are what the adjustment leaves of them, and lengths that follow a station
/// are absorbed.
#[test]
fn whitened_rows_project_onto_what_is_left() {
    for is_tied in [false, true] {
        let (network, solution) = solved(GROUPS, 1e-3, is_tied);
        let rows = Whitened::new(&network, &solution);
        let mut kept = rows.residuals.clone();
        rows.project(&mut kept);
        for (kept, residual) in kept.iter().zip(&rows.residuals) {
            assert!((kept - residual).abs() < 1e-3, "not at the minimum");
        }
        let squares: f64 = rows.residuals.iter().map(|r| r * r).sum();
        assert!((squares / solution.squares - 1.0).abs() < 1e-9);
        // The second station one unit of x away.
        let mut column = vec![0.0; network.readings.len()];
        for visit in network.visits.iter().filter(|v| v.station == 1) {
            for i in visit.readings.clone() {
                let point =
                    solution.points_mm[network.point(visit.group, network.readings[i].point)];
                column[i] = -(point - solution.stations[1].position_mm).normalize().x;
            }
        }
        rows.whiten(&mut column);
        let size = dot(&column, &column);
        rows.project(&mut column);
        let left = dot(&column, &column);
        assert!(left < 1e-9 * size, "{left} of {size}");
    }
}

#[test]
fn what_is_kept_of_single_lengths_is_their_redundancy() {
    // Without a common repeatability the weights are single numbers.
    for (groups, is_tied) in [(GROUPS, false), (GROUPS, true), (MANY_GROUPS, true)] {
        let (network, solution) = solved(groups, 0.0, is_tied);
        let tests = test_all(&BatchInfluence::new(&network, &solution));
        for test in &tests.readings {
            let number = test.redundancy;
            assert!((test.kept - number).abs() < 1e-9, "{} {number}", test.kept);
        }
        let is_tested = |(visit, w): (&Visit, &f64)| (visit.readings.len() > 1) == (*w != 0.0);
        assert!(network.visits.iter().zip(&tests.visits).all(is_tested));
    }
}

#[test]
fn redundancy_numbers_add_up() {
    for is_tied in [false, true] {
        let (network, solution) = solved(GROUPS, 1e-3, is_tied);
        let readings = solution.reliability(&network).into_iter();
        let sum: f64 = readings.map(|reading| reading.redundancy).sum();
        assert!(
            (sum - solution.degrees_of_freedom() as f64).abs() < 1e-7,
            "{sum}"
        );
    }
}

#[test]
fn the_largest_step_is_that_of_all_steps() {
    for is_tied in [false, true] {
        let (network, solution) = solved(GROUPS, 1e-3, is_tied);
        let rows = Whitened::new(&network, &solution);
        let zero_of = network.zero_of_readings();
        let steps = largest_steps(&network, &rows);
        assert_eq!(steps.len(), STATIONS + 1);
        for step in steps {
            let zero = zero_of[step.first_reading];
            let of_zero = (0..zero_of.len()).filter(|&i| zero_of[i] == zero);
            let mut largest = (0.0_f64, 0);
            for first in of_zero.skip(1) {
                let in_step = |i: usize| i >= first && zero_of[i] == zero;
                let error = (0..zero_of.len()).map(|i| f64::from(u8::from(in_step(i))));
                let mut error: Vec<f64> = error.collect();
                rows.whiten(&mut error);
                let mut kept = error.clone();
                rows.project(&mut kept);
                let w = dot(&error, &rows.residuals) / dot(&error, &kept).sqrt();
                if w.abs() > largest.0.abs() {
                    largest = (w, first);
                }
            }
            assert_eq!(step.first_reading, largest.1);
            let (found, expected) = (step.w, largest.0);
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
}
