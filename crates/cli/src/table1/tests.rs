//! The figures of the table by two ways.

use nalgebra::{Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use trueaxis_montecarlo::ChaCha8Rng;
use trueaxis_multilateration::{Noise, solve};

use super::PRINTED;
use super::arrangement::{network, optimised, points_mm, tetrahedron};
use super::figures::{figures, largest_sigmas_mm, measure, sigmas_mm};

/// 500 trials of each row: where a standard deviation is largest by the covariance, that of the
/// trials agrees within four standard errors (24 figures: a failure has a probability of 1.5e-3).
/// Over all coordinates of a row the mean square of these deviations is one within 0.4 (it scatters
/// by 0.07, found with 40 other seeds).
#[test]
fn monte_carlo_agrees_with_the_covariance() {
    let points_mm = points_mm();
    for (number, arrangement) in [tetrahedron(&points_mm), optimised()].iter().enumerate() {
        for (row, &(_, measurement, _)) in PRINTED.iter().enumerate() {
            let seed = (4 * number + row) as u64;
            let (solution, found) =
                measure(&points_mm, arrangement, measurement, 500, seed).unwrap();
            let averaged = f64::from(measurement.repeats).sqrt();
            let sigmas_mm = sigmas_mm(&solution);
            let sigma_mm = |axis: usize, point: usize| sigmas_mm[point][axis] / averaged;
            let deviation = |axis: usize, point: usize| {
                let one = found.outputs[axis * points_mm.len() + point];
                (one.u - sigma_mm(axis, point)) / one.scatter.u
            };
            for axis in 0..3 {
                let largest = (0..points_mm.len())
                    .max_by(|&a, &b| sigma_mm(axis, a).total_cmp(&sigma_mm(axis, b)))
                    .unwrap();
                assert!(deviation(axis, largest).abs() < 4.0);
            }
            let all = (0..3).flat_map(|axis| (0..points_mm.len()).map(move |p| (axis, p)));
            let squares: f64 = all
                .map(|(axis, point)| deviation(axis, point).powi(2))
                .sum();
            let mean = squares / (3 * points_mm.len()) as f64;
            assert!((mean - 1.0).abs() < 0.4, "{mean}");
        }
    }
}

/// The covariance alone, against figures that were made without this program.
#[test]
fn analytic_figures_of_the_tetrahedron() {
    let points_mm = points_mm();
    assert_eq!(points_mm.len(), 195);
    let expected_um = [[1.28, 1.26, 1.32], [2.08, 2.06, 2.15]];
    for (&(_, measurement, _), expected_um) in PRINTED.iter().step_by(2).zip(expected_um) {
        let found = figures(&points_mm, &tetrahedron(&points_mm), measurement, 100, 1).unwrap();
        for (found, expected) in found.analytic_um.iter().zip(expected_um) {
            assert!((found - expected).abs() < 0.01, "{found} {expected}");
        }
    }
}

/// What rounding the stations to 1 mm costs at most.
const ROUNDING: f64 = 5e-4;

/// The largest standard deviation for lengths of standard deviation one; none where a station is not
/// between 0.3 m and 3 m from every point.
fn largest_sigma(points_mm: &[Point3<f64>], stations_mm: &[Point3<f64>; 4]) -> Option<f64> {
    let mut pairs = stations_mm
        .iter()
        .flat_map(|station| points_mm.iter().map(move |point| (point - station).norm()));
    if !pairs.all(|distance_mm| (300.0..=3000.0).contains(&distance_mm)) {
        return None;
    }
    let noise = Noise::default();
    let network = network(points_mm, stations_mm, noise);
    let solution = solve(&network).ok()?;
    let largest = largest_sigmas_mm(&solution).into_iter().fold(0.0, f64::max);
    Some(largest / noise.length_sigma_mm)
}

/// No allowed place near the stations of the table is better.
#[test]
fn optimised_stations_are_a_minimum() {
    let points_mm = points_mm();
    let kept_mm = optimised().stations_mm;
    let least = largest_sigma(&points_mm, &kept_mm).unwrap();
    let rng = &mut ChaCha8Rng::seed_from_u64(5);
    for size_mm in [3.0, 30.0, 300.0] {
        let moves = std::iter::repeat_with(|| {
            let moved_mm = kept_mm.map(|station| {
                let direction = Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
                station + direction * size_mm
            });
            largest_sigma(&points_mm, &moved_mm)
        });
        for found in moves.flatten().take(20) {
            assert!(found > least - ROUNDING, "{found} {least}");
        }
    }
}
