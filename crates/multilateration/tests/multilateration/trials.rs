//! Monte Carlo trials against full solutions of the same lengths and against the covariance, drawn errors against the noise
//! they are drawn from.

use nalgebra::{Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{Corrections, Network, Noise, Solution, Trials, contrast, solve};

use crate::irregular::{self, with_dead_paths};
use crate::world::{network, truth};

const NOISE: Noise = Noise {
    length_sigma_mm: 0.269e-3,
    length_sigma_relative: 0.0,
    repeatability_mm: 1e-3,
};

#[test]
fn corrections_keep_the_datum() {
    let truth = truth(100.0);
    let network = network(&truth, truth.points.clone(), 1, NOISE);
    let solution = solve(&network).unwrap();
    let trials = Trials::new(&network, &solution);
    let mut workspace = trials.workspace();
    let mut errors_mm = vec![0.0; trials.errors()];
    trials.draw(&mut ChaCha8Rng::seed_from_u64(12), &mut errors_mm);
    let corrections = trials.solve(&errors_mm, &mut workspace);
    let (mut shift, mut turn, mut size) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (i, nominal) in network.nominal_mm.iter().enumerate() {
        let correction = corrections.points_mm()[i];
        shift += correction;
        turn += nominal.coords.cross(&correction);
        size += correction.norm();
    }
    assert!(size > 1e-3);
    assert!(shift.norm() < 1e-9 * size, "{shift}");
    assert!(turn.norm() < 1e-6 * size, "{turn}"); // mm², of lever arms of about 1000 mm
}

/// 4000 trials: the scatter of every coordinate is its stated standard deviation. A sample standard
/// deviation of 4000 is good to 1.1 %; 151 of them leave 5 standard errors with a probability below
/// 1e-4.
#[test]
fn scatter_of_trials_is_the_stated_covariance() {
    const TRIALS: usize = 4000;
    let truth = truth(100.0);
    let network = network(&truth, truth.points.clone(), 1, NOISE);
    let solution = solve(&network).unwrap();
    let trials = Trials::new(&network, &solution);
    let mut workspace = trials.workspace();
    let mut errors_mm = vec![0.0; trials.errors()];
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let mut point_squares = vec![Vector3::zeros(); truth.points.len()];
    let mut station_squares = [[0.0; 4]; 4];
    for _ in 0..TRIALS {
        trials.draw(&mut rng, &mut errors_mm);
        let corrections = trials.solve(&errors_mm, &mut workspace);
        for (i, squares) in point_squares.iter_mut().enumerate() {
            *squares += corrections.points_mm()[i].map(|x| x * x);
        }
        for (j, squares) in station_squares.iter_mut().enumerate() {
            let position = corrections.station_mm(j);
            let values = [
                position.x,
                position.y,
                position.z,
                corrections.dead_path_mm(j),
            ];
            for (square, value) in squares.iter_mut().zip(values) {
                *square += value * value;
            }
        }
    }
    let standard_error = (0.5 / TRIALS as f64).sqrt();
    let check = |squares: f64, variance: f64| {
        let ratio = (squares / TRIALS as f64 / variance).sqrt();
        assert!((ratio - 1.0).abs() < 5.0 * standard_error, "{ratio}");
    };
    for (i, squares) in point_squares.iter().enumerate() {
        let covariance = solution.covariance.block(i / 3);
        for k in 0..3 {
            let place = 3 * (i % 3) + k;
            check(squares[k], covariance[(place, place)]);
        }
    }
    for (j, squares) in station_squares.iter().enumerate() {
        let covariance = solution.station_covariance(j);
        for k in 0..4 {
            check(squares[k], covariance[(k, k)]);
        }
    }
}

/// 20,000 draws of one visit: the mean products of its errors are `C`. Their standard errors are
/// `√((C_ii C_jj + C_ij²) / n)`; six of them leave five with a probability below 4e-6.
#[test]
fn drawn_errors_have_the_covariance_of_the_noise() {
    const DRAWS: usize = 20_000;
    let noise = Noise {
        length_sigma_relative: 1e-6,
        ..NOISE
    };
    let truth = truth(200.0);
    let network = network(&truth, truth.points.clone(), 1, noise);
    let solution = solve(&network).unwrap();
    let trials = Trials::new(&network, &solution);
    let visit = network.visits[5].clone();
    let mut errors_mm = vec![0.0; trials.errors()];
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    let mut products = [[0.0; 3]; 3];
    for _ in 0..DRAWS {
        trials.draw(&mut rng, &mut errors_mm);
        let errors = &errors_mm[visit.readings.clone()];
        for i in 0..3 {
            for j in 0..3 {
                products[i][j] += errors[i] * errors[j] / DRAWS as f64;
            }
        }
    }
    let beam = |i: usize| -> Vector3<f64> {
        let station: Point3<f64> = solution.stations[visit.station].position_mm;
        solution.points_mm[network.groups[visit.group].start + i] - station
    };
    let c = |i: usize, j: usize| {
        let own = noise.length_sigma_at_mm(beam(i).norm()).powi(2);
        let common = noise.repeatability_mm.powi(2) * beam(i).normalize().dot(&beam(j).normalize());
        common + if i == j { own } else { 0.0 }
    };
    for (i, products) in products.iter().enumerate() {
        for (j, product) in products.iter().enumerate().take(i + 1) {
            let expected = c(i, j);
            let standard_error = ((c(i, i) * c(j, j) + expected * expected) / DRAWS as f64).sqrt();
            let difference = product - expected;
            assert!(difference.abs() < 5.0 * standard_error, "{i} {j}");
        }
    }
}

/// A trial whose lengths no solution fits is not passed off as one.
#[test]
fn errors_without_a_solution_give_nan() {
    let truth = truth(200.0);
    let network = network(&truth, truth.points.clone(), 1, NOISE);
    let solution = solve(&network).unwrap();
    let trials = Trials::new(&network, &solution);
    let mut workspace = trials.workspace();
    let mut errors_mm = vec![0.0; trials.errors()];
    trials.draw(&mut ChaCha8Rng::seed_from_u64(15), &mut errors_mm);
    let good = trials.solve(&errors_mm, &mut workspace).clone();
    for bad in [f64::NAN, f64::INFINITY, 1e5] {
        let mut spoilt_mm = errors_mm.clone();
        spoilt_mm[3] = bad;
        let spoilt = trials.solve(&spoilt_mm, &mut workspace);
        assert!(spoilt.points_mm().iter().flatten().all(|x| x.is_nan()));
        assert!(spoilt.dead_path_mm(2).is_nan());
        // Nothing of it is left behind.
        assert_eq!(trials.solve(&errors_mm, &mut workspace), &good);
    }
}

/// The lengths that follow from a solution, plus errors, and what is known beside them plus its own.
fn disturbed(network: &Network, solution: &Solution, errors: &[f64]) -> Network {
    let (errors_mm, of_known) = errors.split_at(network.readings.len());
    let mut disturbed = network.clone();
    for (known, error) in disturbed.dead_paths.iter_mut().zip(of_known) {
        let computed_mm = solution.stations[known.station].dead_path_mm;
        known.length_mm = computed_mm + solution.mean_constant_mm.unwrap() + error * known.sigma_mm;
    }
    let residuals = errors_mm.iter().zip(&solution.residuals_mm);
    for (reading, (error, residual)) in disturbed.readings.iter_mut().zip(residuals) {
        reading.length_mm += error - residual;
    }
    disturbed
}

/// The largest difference of any unknown between a trial and a full solution, in units of its standard uncertainty.
fn largest_difference(
    network: &Network,
    trial: &Corrections,
    full: &Solution,
    base: &Solution,
) -> f64 {
    let mut largest = 0.0_f64;
    let mut compare = |difference: f64, variance: f64| {
        assert!(difference.is_finite());
        largest = largest.max(difference.abs() / variance.sqrt());
    };
    for (group, points) in network.groups.iter().enumerate() {
        let covariance = base.covariance.block(group);
        for point in points.clone() {
            let moved = full.points_mm[point] - base.points_mm[point];
            compare(
                (trial.points_mm()[point] - moved).norm(),
                covariance[(0, 0)],
            );
        }
        let is_tied = network
            .bodies
            .as_ref()
            .is_some_and(|bodies| bodies.of_groups[group].body.is_some());
        if is_tied {
            let motion = full.poses[group] * base.poses[group].inverse();
            let centre = centroid(&base.points_mm[points.clone()]);
            let shift = motion * centre - centre;
            let turn = motion.rotation.scaled_axis();
            let expected = shift.iter().chain(turn.iter());
            for (k, (found, expected)) in trial.group(group).iter().zip(expected).enumerate() {
                compare(found - expected, covariance[(k, k)]);
            }
        }
    }
    let dead_paths = |solution: &Solution| -> Vec<f64> {
        let of_stations = solution.stations.iter().map(|s| s.dead_path_mm);
        of_stations
            .chain(solution.dead_paths_after_mm.clone())
            .collect()
    };
    let (before, after) = (dead_paths(base), dead_paths(full));
    for station in 0..network.stations.len() {
        let covariance = base.station_covariance(station);
        let moved = full.stations[station].position_mm - base.stations[station].position_mm;
        let difference = trial.station_mm(station) - moved;
        for k in 0..3 {
            compare(difference[k], covariance[(k, k)]);
        }
    }
    let shared = base.covariance.shared();
    for zero in 0..before.len() {
        let stations = network.stations.len();
        let column = match zero < stations {
            true => 4 * zero + 3,
            false => 3 * stations + zero,
        };
        let variance = shared[(column, column)];
        let expected = after[zero] - before[zero];
        compare(trial.dead_path_mm(zero) - expected, variance);
    }
    let mean = base.mean_constant_column().unwrap();
    let expected = full.mean_constant_mm.unwrap() - base.mean_constant_mm.unwrap();
    compare(trial.mean_constant_mm() - expected, shared[(mean, mean)]);
    for m in 0..2 {
        let constants = full
            .reflectors_mm
            .iter()
            .zip(&base.reflectors_mm)
            .enumerate();
        let expected: f64 = constants.map(|(r, (a, b))| contrast(r, m) * (a - b)).sum();
        let column = mean + 1 + m;
        compare(
            trial.shared_mm()[column] - expected,
            shared[(column, column)],
        );
    }
    largest
}

/// The errors of lengths and of what is known with which a full solution is the true one: nothing is left, so that it is the
/// same with any weights.
fn errors_of(network: &Network, base: &Solution, disturbed: &Network, full: &Solution) -> Vec<f64> {
    let computed = |network: &Network, solution: &Solution| -> Vec<f64> {
        let readings = network.readings.iter().zip(&solution.residuals_mm);
        readings
            .map(|(reading, residual)| reading.length_mm - residual)
            .collect()
    };
    let pairs = computed(disturbed, full)
        .into_iter()
        .zip(computed(network, base));
    let constants = [full, base].map(|solution| solution.mean_constant_mm.unwrap());
    let of_known = network.dead_paths.iter().map(|known| {
        let [after, before] =
            [full, base].map(|solution| solution.stations[known.station].dead_path_mm);
        (after + constants[0] - before - constants[1]) / known.sigma_mm
    });
    pairs
        .map(|(after, before)| after - before)
        .chain(of_known)
        .collect()
}

/// How far the linear answer is off at any point, in units of its standard uncertainty.
fn linear_misses(trials: &Trials, errors: &[f64], full: &Solution, base: &Solution) -> f64 {
    const SMALL: f64 = 1e-4;
    let small: Vec<f64> = errors.iter().map(|error| SMALL * error).collect();
    let mut workspace = trials.workspace();
    let linear = trials.solve(&small, &mut workspace);
    let u_mm = base.covariance.block(0)[(0, 0)].sqrt();
    let places = full.points_mm.iter().zip(&base.points_mm);
    let missed = places.enumerate().map(|(i, (after, before))| {
        (linear.points_mm()[i] / SMALL - (after - before)).norm() / u_mm
    });
    missed.fold(0.0, f64::max)
}

/// Which errors a trial is given.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    /// As they are drawn, so many times as large.
    Drawn(f64),
    /// Those with which the full solution of drawn ones is the true one.
    OfSolution(f64),
}

/// Five trials against full solutions of the same lengths. Where weights depend on the beams, full solutions weigh by their own,
/// and what that does grows with the square of the errors; it does nothing where no residuals are left.
#[test]
fn trials_are_the_full_solution() {
    let equal = Noise {
        repeatability_mm: 0.0,
        ..NOISE
    };
    let of_beams = Noise {
        length_sigma_relative: 5e-7,
        ..NOISE
    };
    let cases = [
        (equal, Given::Drawn(1.0), 1e-6),
        (equal, Given::Drawn(10.0), 1e-6),
        (of_beams, Given::Drawn(0.01), 1e-7),
        (of_beams, Given::OfSolution(1.0), 1e-6),
        (of_beams, Given::OfSolution(10.0), 1e-6),
    ];
    for ((noise, given, limit), is_tied) in cases.iter().flat_map(|c| [(c, false), (c, true)]) {
        let network = with_dead_paths(irregular::network(30, *noise, is_tied));
        let solution = solve(&network).unwrap();
        assert!(solution.termination.is_converged());
        let trials = Trials::new(&network, &solution);
        let mut workspace = trials.workspace();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut errors = vec![0.0; trials.errors()];
        let (Given::Drawn(factor) | Given::OfSolution(factor)) = *given;
        let (mut largest, mut linear) = (0.0_f64, 0.0_f64);
        for _ in 0..5 {
            trials.draw(&mut rng, &mut errors);
            errors.iter_mut().for_each(|error| *error *= factor);
            let disturbed = disturbed(&network, &solution, &errors);
            let full = solve(&disturbed).unwrap();
            assert!(full.termination.is_converged());
            let errors = match given {
                Given::Drawn(_) => errors.clone(),
                Given::OfSolution(_) => errors_of(&network, &solution, &disturbed, &full),
            };
            let trial = trials.solve(&errors, &mut workspace);
            largest = largest.max(largest_difference(&network, trial, &full, &solution));
            linear = linear.max(linear_misses(&trials, &errors, &full, &solution));
        }
        println!("{noise:?}, tied {is_tied}, {given:?}: {largest:.1e} u, linear {linear:.1e} u");
        assert!(largest < *limit);
        // It takes the corrections.
        assert!(factor < 10.0 || linear > 1e-3);
    }
}
