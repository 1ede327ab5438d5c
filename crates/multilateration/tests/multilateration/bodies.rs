//! Points tied to rigid bodies: exactness, covariance, noise, and the way to free points and back.

use nalgebra::{Isometry3, Point3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::{Network, Noise, Solution, are_in_line, solve, solve_from};

use crate::deviation::largest_deviation_mm;
use crate::world::*;

const NOISE: Noise = Noise {
    length_sigma_mm: 0.269e-3,
    length_sigma_relative: 0.0,
    repeatability_mm: 1e-3,
};

/// Bodies that stand up to half a millimetre and milliradian off nominal and whose shape is off by 0.2 mm.
fn displaced(seed: u64) -> (Truth, Vec<Point3<f64>>) {
    let mut truth = truth(50.0);
    let nominal = truth.points.clone();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut vector = |size: f64| Vector3::from_fn(|_, _| (rng.random::<f64>() - 0.5) * size);
    let shape = [vector(0.4), vector(0.4), vector(0.4)];
    for points in truth.points.chunks_mut(3) {
        let motion = Isometry3::new(vector(1.0), vector(1e-3));
        let centre = points[0].coords;
        for (point, shape) in points.iter_mut().zip(&shape) {
            *point = motion * (*point - centre + shape) + centre;
        }
    }
    (truth, nominal)
}

fn noisy(truth: &Truth, nominal: &[Point3<f64>], rng: &mut ChaCha8Rng) -> Network {
    let mut network = network(truth, nominal.to_vec(), 1, NOISE);
    add_noise(&mut network, truth, rng);
    tied(&network)
}

#[test]
fn exact_lengths_give_exact_bodies() {
    let (truth, nominal) = displaced(1);
    let network = tied(&network(&truth, nominal.clone(), 1, NOISE));
    let solution = solve(&network).unwrap();
    assert!(solution.termination.is_converged());
    let deviation_mm = largest_deviation_mm(&solution, &truth, &nominal);
    assert!(deviation_mm < 1e-8, "{deviation_mm:e}");
    let groups = network.groups.len();
    assert_eq!(solution.unknowns, 6 * groups + 16 + 3 - 6);
    assert_eq!(solution.poses.len(), groups);
    for (g, points) in network.groups.iter().enumerate() {
        for (k, point) in points.clone().enumerate() {
            let place = solution.poses[g] * solution.shapes_mm[0][k];
            assert!((place - solution.points_mm[point]).norm() < 1e-9);
        }
    }
}

fn largest_difference_mm(a: &Solution, b: &Solution) -> f64 {
    let points = a.points_mm.iter().zip(&b.points_mm);
    points.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// From the tied minimum to the free one and back: two iterations move it, the third finds nothing left.
#[test]
fn one_kind_leads_to_the_other() {
    let (truth, nominal) = displaced(2);
    let joint = noisy(&truth, &nominal, &mut ChaCha8Rng::seed_from_u64(3));
    let free = Network {
        bodies: None,
        ..joint.clone()
    };
    let (tied, loose) = (solve(&joint).unwrap(), solve(&free).unwrap());
    let there = solve_from(&free, &tied).unwrap();
    let back = solve_from(&joint, &loose).unwrap();
    println!("{} and {} iterations", there.iterations, back.iterations);
    assert!(there.iterations.max(back.iterations) <= 3 && there.poses.is_empty());
    assert!(largest_difference_mm(&there, &loose) < 1e-9);
    assert!(largest_difference_mm(&back, &tied) < 1e-9);
    assert!((back.squares / tied.squares - 1.0).abs() < 1e-9);
    let again = solve_from(&joint, &tied).unwrap();
    assert!(again.iterations <= 2);
}

/// 400 noisy campaigns: the scatter of every pose and of the shape equals its stated standard deviation. A
/// sample standard deviation of 400 is good to 3.5 %; 19 of them leave 5 standard errors with a probability
/// below 2e-5. σ0 has mean one to 5 standard errors (6e-7).
#[test]
fn stated_covariance_is_the_scatter() {
    const TRIALS: usize = 400;
    let truth = truth(100.0);
    let clean = tied(&network(&truth, truth.points.clone(), 1, NOISE));
    let reference = solve(&clean).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let groups = [0, 7, 12];
    let mut squares = vec![[0.0; 6]; groups.len()];
    let mut shape_squares = 0.0;
    let mut variance_factors = 0.0;
    for _ in 0..TRIALS {
        let solution = solve(&noisy(&truth, &truth.points, &mut rng));
        let solution = solution.unwrap();
        variance_factors += solution.sigma0().powi(2);
        for (squares, &g) in squares.iter_mut().zip(&groups) {
            let motion = solution.poses[g] * reference.poses[g].inverse();
            let points = &reference.points_mm[3 * g..3 * g + 3];
            let centre = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / 3.0;
            let shift = motion * Point3::from(centre) - Point3::from(centre);
            let turn = motion.rotation.scaled_axis();
            for (square, x) in squares.iter_mut().zip(shift.iter().chain(turn.iter())) {
                *square += x * x;
            }
        }
        let shapes = solution.shapes_mm[0].iter().zip(&reference.shapes_mm[0]);
        shape_squares += shapes.map(|(p, q)| (p - q).norm_squared()).sum::<f64>();
    }
    let limit = 5.0 * (0.5 / TRIALS as f64).sqrt();
    for (squares, &g) in squares.iter().zip(&groups) {
        let covariance = reference.covariance.block(g);
        for (k, square) in squares.iter().enumerate() {
            let ratio = (square / TRIALS as f64 / covariance[(k, k)]).sqrt();
            assert!(
                (ratio - 1.0).abs() < limit,
                "unknown {k} of group {g}: {ratio}"
            );
        }
    }
    // The deformations are orthonormal: their squares add up to those of the points. Alone they would scatter
    // by √2 of their mean, together by less.
    let shared = reference.covariance.shared();
    let stated: f64 = (16..19).map(|k| shared[(k, k)]).sum();
    let ratio = shape_squares / TRIALS as f64 / stated;
    assert!(
        (ratio - 1.0).abs() < 5.0 * (2.0 / TRIALS as f64).sqrt(),
        "{ratio}"
    );
    let dof = reference.degrees_of_freedom() as f64;
    let standard_error = (2.0 / dof / TRIALS as f64).sqrt();
    let mean = variance_factors / TRIALS as f64;
    assert!((mean - 1.0).abs() < 5.0 * standard_error, "{mean}");
}

#[test]
fn three_points_in_line_are_no_body() {
    let at = |x: f64, y: f64| Point3::new(x, y, 5.0);
    assert!(are_in_line(&[at(0.0, 0.0), at(1.0, 1.0)]));
    assert!(are_in_line(&[at(0.0, 0.0), at(1.0, 1.0), at(3.0, 3.0)]));
    assert!(!are_in_line(&[at(0.0, 0.0), at(1.0, 1.0), at(3.0, 3.1)]));
}
