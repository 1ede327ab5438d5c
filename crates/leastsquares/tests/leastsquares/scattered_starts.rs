//! From starts scattered around NIST's, whatever is called converged is a local minimum.
//!
//! Few of these starts are sensible: the sums of squares have other minima, and lower values at
//! infinity. But where the solver says that it has arrived, nothing beside may be lower. That is
//! seen here from the residuals alone.

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_leastsquares::dense::{Adjusted, Model, adjust};

use crate::nist_strd::{digits, regressions};
use crate::strd_models::Regression;

const STARTS: usize = 6;
const NEIGHBOURS: usize = 100;

/// Runaways use up whatever they are given.
const MAX_ITERATIONS: usize = 200;

#[test]
fn converged_means_a_local_minimum() {
    let mut random = ChaCha8Rng::seed_from_u64(27);
    let (mut certified, mut other, mut open) = (0, 0, 0);
    for regression in regressions() {
        let set = &regression.set;
        for k in 0..STARTS {
            let start: Vec<f64> = set.starts[k % 2]
                .iter()
                .map(|b| b * 10_f64.powf(random.random_range(-1.0..1.0)))
                .collect();
            let Ok(adjusted) = adjust(&regression, &start, MAX_ITERATIONS) else {
                open += 1; // not finite at the start
                continue;
            };
            if !adjusted.termination.is_converged() {
                open += 1;
                continue;
            }
            if digits(&adjusted.unknowns, &set.certified.unknowns) > 6.0 {
                certified += 1;
            } else {
                other += 1;
            }
            let rise = least_rise(&regression, &adjusted, &mut random);
            assert!(rise > 0.0, "{}: {rise:.1e} from {start:?}", set.name);
        }
    }
    println!("{certified} at the certified values, {other} at other minima, {open} not converged");
    // Both kinds must occur for the test to mean something.
    assert!(certified > 50 && other > 10 && open > 10);
}

/// Least change of the sum of squares to points whose linearised residuals differ by 0.001 of
/// their norm in random directions, relative to the linear model (one where it is exact).
fn least_rise(regression: &Regression, adjusted: &Adjusted, random: &mut ChaCha8Rng) -> f64 {
    let responses: f64 = regression
        .set
        .rows
        .iter()
        .map(|row| row.response.powi(2))
        .sum();
    // Beyond the rounding of the residuals, too.
    let length = f64::max(1e-3 * adjusted.squares.sqrt(), 1e-13 * responses.sqrt());
    let unknowns = adjusted.unknowns.len();
    let covariance = adjusted.covariance.as_ref().unwrap();
    let deviations: Vec<f64> = (0..unknowns).map(|j| covariance[(j, j)].sqrt()).collect();
    let correlation = DMatrix::from_fn(unknowns, unknowns, |i, j| {
        covariance[(i, j)] / (deviations[i] * deviations[j])
    });
    let eigen = correlation.symmetric_eigen();
    let (values, vectors) = (eigen.eigenvalues, eigen.eigenvectors);
    let mut least = f64::INFINITY;
    for _ in 0..NEIGHBOURS {
        let mut direction: Vec<f64> = (0..unknowns)
            .map(|_| random.random_range(-1.0..1.0))
            .collect();
        let size = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (k, x) in direction.iter_mut().enumerate() {
            *x *= length / size * values[k].max(0.0).sqrt();
        }
        let beside: Vec<f64> = (0..unknowns)
            .map(|j| {
                let change: f64 = (0..unknowns).map(|k| vectors[(j, k)] * direction[k]).sum();
                adjusted.unknowns[j] + deviations[j] * change
            })
            .collect();
        let residuals = regression.residuals(&beside);
        let pairs = residuals.iter().zip(&adjusted.residuals);
        let rise: f64 = pairs.map(|(a, b)| (a - b) * (a + b)).sum();
        least = least.min(rise / (length * length));
    }
    least
}
