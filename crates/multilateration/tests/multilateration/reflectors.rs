//! Reflectors that differ: their constants are found, free and tied, and their covariance is the scatter.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trueaxis_multilateration::{Error, Network, Noise, Reflectors, Solution, contrast, solve};

use crate::deviation::{disturbed, largest_deviation_mm};
use crate::world::*;

const NOISE: Noise = Noise {
    length_sigma_mm: 0.269e-3,
    length_sigma_relative: 0.0,
    repeatability_mm: 1e-3,
};

/// Constants of sum zero, mm.
const CONSTANTS_MM: [f64; 3] = [3e-3, -1e-3, -2e-3];

/// Three targets with these constants at each step, whose reflectors are unknown.
fn with_reflectors(mut network: Network, constants_mm: [f64; 3], sigma_mm: Option<f64>) -> Network {
    for visit in &network.visits {
        for reading in &mut network.readings[visit.readings.clone()] {
            reading.length_mm += constants_mm[reading.point];
        }
    }
    let points = network.nominal_mm.len();
    network.reflectors = Some(Arc::new(Reflectors {
        count: 3,
        sigma_mm,
        of_points: (0..points).map(|point| point % 3).collect(),
    }));
    network
}

#[test]
fn exact_lengths_give_exact_constants() {
    let truth = truth(50.0);
    let nominal = disturbed(&truth.points, 0.05, 7);
    let free = network(&truth, nominal.clone(), 1, NOISE);
    let free = with_reflectors(free, CONSTANTS_MM, None);
    // Tied points are rigid: their true places are nominal.
    let joint = tied(&network(&truth, truth.points.clone(), 1, NOISE));
    let joint = with_reflectors(joint, CONSTANTS_MM, None);
    for (network, nominal) in [(free, &nominal), (joint, &truth.points)] {
        let solution = solve(&network).unwrap();
        assert!(solution.termination.is_converged());
        let deviation_mm = largest_deviation_mm(&solution, &truth, nominal);
        assert!(deviation_mm < 1e-7, "{deviation_mm:e}");
        for (found, expected) in solution.reflectors_mm.iter().zip(CONSTANTS_MM) {
            assert!((found - expected).abs() < 1e-8, "{found}");
        }
        let without = Network {
            reflectors: None,
            ..network.clone()
        };
        let alike = solve(&without).unwrap();
        assert_eq!(solution.unknowns, alike.unknowns + 2);
        let wrong_mm = largest_deviation_mm(&alike, &truth, nominal);
        assert!(wrong_mm > 1e-3, "{wrong_mm:e}");
    }
}

fn constants(solution: &Solution) -> DVector<f64> {
    DVector::from_column_slice(&solution.reflectors_mm)
}

/// 300 networks each, with constants of their own drawn anew and known beforehand or not: the squares of what
/// is left, by the stated covariance, have the mean two, the number of contrasts. Their mean over 300 is good to
/// 0.115; it leaves 5 standard errors with a probability of 6e-7.
#[test]
fn stated_covariance_is_the_scatter() {
    const TRIALS: usize = 300;
    const SIGMA_MM: f64 = 0.3e-3;
    let truth = truth(100.0);
    for (is_tied, sigma_mm) in [
        (true, None),
        (true, Some(SIGMA_MM)),
        (false, Some(SIGMA_MM)),
    ] {
        let mut rng = ChaCha8Rng::seed_from_u64(30);
        let mut mean = 0.0;
        for _ in 0..TRIALS {
            let mut network = network(&truth, truth.points.clone(), 1, NOISE);
            add_noise(&mut network, &truth, &mut rng);
            let drawn: [f64; 3] =
                std::array::from_fn(|_| SIGMA_MM * rng.sample::<f64, _>(StandardNormal));
            let network = if is_tied { tied(&network) } else { network };
            let network = with_reflectors(network, drawn, sigma_mm);
            let solution = solve(&network).unwrap();
            let expected = DVector::from_column_slice(&drawn);
            let expected = &expected - DVector::from_element(3, expected.mean());
            let left = constants(&solution) - expected;
            // Their mean is zero: any variance of it makes the covariance regular.
            let covariance = solution.reflector_covariance();
            let of_mean = DMatrix::from_element(3, 3, covariance.trace());
            let inverse = (covariance + of_mean).try_inverse().unwrap();
            mean += left.dot(&(inverse * &left)) / TRIALS as f64;
        }
        println!("tied {is_tied}, known {sigma_mm:?}: {mean:.3}");
        let limit = 5.0 * (4.0 / TRIALS as f64).sqrt();
        assert!((mean - 2.0).abs() < limit, "{is_tied} {sigma_mm:?}: {mean}");
    }
}

/// A reflector that three stations see once: its three lengths place it, and nothing is left for its constant.
/// Without knowledge of it that is said; with it the constant is as uncertain as it was.
#[test]
fn constants_that_are_not_determined_are_named() {
    const SIGMA_MM: f64 = 2e-3;
    let truth = truth(50.0);
    let whole = network(&truth, truth.points.clone(), 1, NOISE);
    let odd = 4;
    let seen = whole
        .visits
        .iter()
        .filter(|visit| visit.station == 0)
        .flat_map(|visit| visit.readings.clone().map(move |i| (visit.group, i)));
    let of_odd = |&(group, i): &(usize, usize)| 3 * group + whole.readings[i].point == odd;
    let removed: Vec<usize> = seen.filter(of_odd).map(|(_, i)| i).collect();
    assert_eq!(removed.len(), 1);
    let (mut network, _) = whole.without(&removed);
    let points = network.nominal_mm.len();
    let mut reflectors = Reflectors {
        count: 2,
        sigma_mm: None,
        of_points: (0..points).map(|p| usize::from(p == odd)).collect(),
    };
    network.reflectors = Some(Arc::new(reflectors.clone()));
    let open = solve(&network).map(|_| ());
    assert!(
        matches!(open, Err(Error::ReflectorsNotDetermined { .. })),
        "{open:?}"
    );
    reflectors.sigma_mm = Some(SIGMA_MM);
    network.reflectors = Some(Arc::new(reflectors));
    let known = solve(&network).unwrap();
    // Half the difference of two constants.
    let u_mm = known.reflector_covariance()[(0, 0)].sqrt();
    assert!(
        (u_mm / (SIGMA_MM / 2_f64.sqrt()) - 1.0).abs() < 1e-6,
        "{u_mm}"
    );
}

#[test]
fn contrasts_are_orthonormal_and_have_no_mean() {
    const COUNT: usize = 8;
    for m in 0..COUNT - 1 {
        let sum: f64 = (0..COUNT).map(|r| contrast(r, m)).sum();
        assert!(sum.abs() < 1e-15);
        for n in 0..COUNT - 1 {
            let product: f64 = (0..COUNT).map(|r| contrast(r, m) * contrast(r, n)).sum();
            let expected = f64::from(u8::from(m == n));
            assert!((product - expected).abs() < 1e-15, "{m} {n}");
        }
    }
}
