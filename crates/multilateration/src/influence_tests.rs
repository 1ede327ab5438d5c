//! What is made of the hat matrix eight groups at a time, and of its rows reading by reading, against the
//! matrices of single groups ([`crate::influence`]).

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::BlockRows;
use trueaxis_leastsquares::lane_products::LaneMatrix;

use crate::baarda::test_all;
use crate::batch_influence::{BatchInfluence, BatchRows};
use crate::influence::{GroupRows, Influence};
use crate::noise::whiten;
use crate::step_tests::largest_steps;
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

/// Groups of three points (the last of two) with some readings missing, one of them of little weight, an
/// interruption in the middle of a visit, and errors of micrometres.
fn solved(groups: usize, return_sigma_mm: f64) -> (Network, Solution) {
    let mut network = Network {
        stations: (0..STATIONS).map(|j| Some(place(j + 20, 2000.0))).collect(),
        noise: Noise {
            length_sigma_relative: 5e-7,
            return_sigma_mm,
            ..Noise::default()
        },
        ..Network::default()
    };
    for group in 0..groups {
        let first = 3 * group;
        let points = if group + 1 < groups { 3 } else { 2 };
        network.groups.push(first..first + points);
        network
            .nominal_mm
            .extend((first..first + points).map(|i| place(i, 400.0)));
    }
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

#[test]
fn rows_have_the_trace_of_the_unknowns() {
    let (network, solution) = solved(GROUPS, 1e-3);
    let influence = BatchInfluence::new(&network, &solution);
    let mut rows = BatchRows::default();
    let mut squares = 0.0;
    let mut trace = 0.0;
    for b in 0..influence.batches().len() {
        influence.fill(b, &mut rows);
        let (own, shared) = (rows.hat.own(), rows.hat.shared());
        let at = |m: LaneMatrix<'_>, lane: usize, i: usize, j: usize| m.at(i, j).0[lane];
        for lane in 0..8 {
            for i in 0..own.rows() {
                squares += rows.hat.residual()[i].0[lane].powi(2);
                trace += (0..own.columns())
                    .map(|k| at(own, lane, i, k).powi(2))
                    .sum::<f64>();
                for k in 0..influence.width() {
                    for l in 0..influence.width() {
                        let sigma = influence.sigma()[k * influence.width() + l];
                        trace += at(shared, lane, i, k) * sigma * at(shared, lane, i, l);
                    }
                }
            }
        }
    }
    let redundant = network.readings.len() as f64 - trace;
    assert!(
        (redundant - solution.degrees_of_freedom() as f64).abs() < 1e-7,
        "{redundant}"
    );
    assert!((squares / solution.squares - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_kept_of_single_lengths_is_their_redundancy() {
    // Without a common return the weights are single numbers.
    for groups in [GROUPS, MANY_GROUPS] {
        let (network, solution) = solved(groups, 0.0);
        let tests = test_all(&BatchInfluence::new(&network, &solution));
        let numbers = solution.redundancy_numbers(&network);
        for (test, number) in tests.readings.iter().zip(&numbers) {
            assert!((test.kept - number).abs() < 1e-9, "{} {number}", test.kept);
        }
        let is_tested = |(visit, w): (&Visit, &f64)| (visit.readings.len() > 1) == (*w != 0.0);
        assert!(network.visits.iter().zip(&tests.visits).all(is_tested));
    }
}

/// `w` of a whitened error in some rows of each group.
fn dense_w(influence: &Influence<'_>, groups: &[GroupRows], errors: &[Vec<f64>]) -> f64 {
    let sigma = influence.reduced_inverse();
    let (mut numerator, mut kept) = (0.0, 0.0);
    let mut through = vec![0.0; sigma.ncols()];
    for (group, error) in groups.iter().zip(errors) {
        for (i, e) in error.iter().enumerate() {
            numerator += e * group.residuals[i];
            kept += e * e;
            for (k, t) in through.iter_mut().enumerate() {
                *t += e * group.shared[(i, k)];
            }
        }
        for k in 0..group.own.ncols() {
            let own: f64 = error
                .iter()
                .enumerate()
                .map(|(i, e)| e * group.own[(i, k)])
                .sum();
            kept -= own * own;
        }
    }
    for k in 0..through.len() {
        for l in 0..through.len() {
            kept -= through[k] * sigma[(k, l)] * through[l];
        }
    }
    numerator / kept.sqrt()
}

#[test]
fn the_largest_step_is_that_of_all_steps() {
    let (network, solution) = solved(GROUPS, 1e-3);
    let influence = Influence::new(&network, &solution);
    let mut memory = BlockRows::default();
    let groups: Vec<GroupRows> = (0..GROUPS)
        .map(|g| influence.group(g, &mut memory))
        .collect();
    let zero_of = network.zero_of_readings();
    let steps = largest_steps(&influence);
    assert_eq!(steps.len(), STATIONS + 1);
    for step in steps {
        let zero = zero_of[step.first_reading];
        let of_zero = (0..zero_of.len()).filter(|&i| zero_of[i] == zero);
        let mut largest = (0.0_f64, 0);
        for first in of_zero.skip(1) {
            let in_step = |i: usize| i >= first && zero_of[i] == zero;
            let whitened = |group: &GroupRows| {
                let mut error = vec![0.0; group.residuals.len()];
                for visit in &group.visits {
                    let rows = &mut error[visit.first..visit.first + visit.count];
                    let readings = network.visits[visit.visit].readings.clone();
                    for (row, i) in rows.iter_mut().zip(readings) {
                        *row = f64::from(u8::from(in_step(i)));
                    }
                    whiten(influence.model().factor(visit.visit), rows);
                }
                error
            };
            let errors: Vec<Vec<f64>> = groups.iter().map(whitened).collect();
            let w = dense_w(&influence, &groups, &errors);
            if w.abs() > largest.0.abs() {
                largest = (w, first);
            }
        }
        assert_eq!(step.first_reading, largest.1);
        assert!(
            (step.w - largest.0).abs() < 1e-6,
            "{} {}",
            step.w,
            largest.0
        );
    }
}
