//! The figures of the table by two ways.

use super::PRINTED;
use super::arrangement::{optimised, points_mm, tetrahedron};
use super::figures::{figures, measure};

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
            let sigma_mm = |axis: usize, point: usize| {
                solution.group_covariance(point)[(axis, axis)].sqrt() / averaged
            };
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
