//! Lengths with known truth: exactness, invariance, covariance.

use nalgebra::{Isometry3, Point3, Vector3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::{Error, Network, Noise, Solution, Visit, solve};

use crate::deviation::{disturbed, largest_deviation_mm};
use crate::world::*;

#[test]
fn exact_lengths_give_exact_points_without_station_approximations() {
    for (seed, size_mm) in [(1, 0.02), (2, 1.0), (3, 5.0)] {
        let mut truth = truth(20.0);
        let nominal = truth.points.clone();
        truth.points = disturbed(&nominal, size_mm, seed);
        let network = network(&truth, nominal.clone(), 1, Noise::default());
        let solution = solve(&network).unwrap();
        assert!(
            solution.termination.is_converged(),
            "{}",
            solution.termination
        );
        let deviation_mm = largest_deviation_mm(&solution, &truth, &nominal);
        assert!(
            deviation_mm < 1e-8,
            "{size_mm} mm off nominal: {deviation_mm:e}"
        );
        assert_eq!(solution.observations, 780);
        assert_eq!(solution.unknowns, 595);
    }
}

#[test]
fn redundancy_numbers_add_up() {
    let truth = truth(100.0);
    let noise = Noise {
        length_sigma_mm: 3e-4,
        repeatability_mm: 1e-3,
        ..Noise::default()
    };
    let network = network(&truth, truth.points.clone(), 2, noise);
    let solution = solve(&network).unwrap();
    let tests = solution.tests(&network);
    let numbers = tests.readings.iter().map(|reading| reading.redundancy);
    let sum: f64 = numbers.clone().sum();
    assert!(
        (sum - solution.degrees_of_freedom() as f64).abs() < 1e-6,
        "{sum}"
    );
    assert!(
        numbers
            .into_iter()
            .all(|r| (-1e-9..=1.0 + 1e-9).contains(&r))
    );
}

/// 400 noisy campaigns: the scatter of every coordinate equals its stated standard deviation.
/// A sample standard deviation of 400 is good to 3.5 %; 40 of them leave 5 standard errors with a
/// probability below 3e-5. σ0 has mean one to 5 standard errors (6e-7).
#[test]
fn stated_covariance_is_the_scatter() {
    const TRIALS: usize = 400;
    let truth = truth(100.0);
    let noise = Noise {
        length_sigma_mm: 3e-4,
        repeatability_mm: 1e-3,
        ..Noise::default()
    };
    let clean = network(&truth, truth.points.clone(), 2, noise);
    let reference = solve(&clean).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(20);
    let groups = [0, 7, 12];
    let mut point_squares = vec![[0.0; 9]; groups.len()];
    let mut station_squares = [[0.0; 4]; 4];
    let mut variance_factors = 0.0;
    for _ in 0..TRIALS {
        let mut noisy = clean.clone();
        add_noise(&mut noisy, &truth, &mut rng);
        let solution = solve(&noisy).unwrap();
        variance_factors += solution.sigma0().powi(2);
        for (squares, &g) in point_squares.iter_mut().zip(&groups) {
            for (k, square) in squares.iter_mut().enumerate() {
                let point = 3 * g + k / 3;
                *square += (solution.points_mm[point] - truth.points[point])[k % 3].powi(2);
            }
        }
        for (j, squares) in station_squares.iter_mut().enumerate() {
            let d = solution.stations[j].position_mm - truth.stations[j].0;
            let l = solution.stations[j].dead_path_mm - truth.stations[j].1;
            for (square, value) in squares.iter_mut().zip([d.x, d.y, d.z, l]) {
                *square += value * value;
            }
        }
    }
    let limit = 5.0 * (0.5 / TRIALS as f64).sqrt();
    let check = |squares: f64, variance: f64, what: &str| {
        let ratio = (squares / TRIALS as f64 / variance).sqrt();
        assert!(
            (ratio - 1.0).abs() < limit,
            "{what}: scatter is {ratio} of the stated u"
        );
    };
    for (squares, &g) in point_squares.iter().zip(&groups) {
        let covariance = reference.covariance.block(g);
        for (k, square) in squares.iter().enumerate() {
            check(*square, covariance[(k, k)], "point");
        }
    }
    for (j, squares) in station_squares.iter().enumerate() {
        let covariance = reference.station_covariance(j);
        for (k, square) in squares.iter().enumerate() {
            check(*square, covariance[(k, k)], "station");
        }
    }
    let dof = reference.degrees_of_freedom() as f64;
    let standard_error = (2.0 / dof / TRIALS as f64).sqrt();
    let mean = variance_factors / TRIALS as f64;
    assert!(
        (mean - 1.0).abs() < 5.0 * standard_error,
        "mean variance factor {mean}"
    );
}

/// The analytic standard deviations behind Table 1 of the paper: 195 points, stations
/// as a regular tetrahedron 800 mm around their centre, `σ_l` = 0.269 µm, `σ_m` = 1 µm and 5/3 µm,
/// every target measured in a visit of its own.
#[test]
fn table_1_single_measurement() {
    let nominal = truth(20.0).points;
    let centre = nominal.iter().map(|p| p.coords).sum::<Vector3<f64>>() / nominal.len() as f64;
    let corners = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let truth = Truth {
        stations: corners
            .map(|c| {
                (
                    Point3::from(centre + Vector3::from(c) * (800.0 / 3.0_f64.sqrt())),
                    50.0,
                )
            })
            .to_vec(),
        points: nominal.clone(),
    };
    for (return_um, expected) in [(1.0, [1.28, 1.26, 1.32]), (5.0 / 3.0, [2.08, 2.06, 2.15])] {
        let noise = Noise {
            length_sigma_mm: 0.269e-3,
            repeatability_mm: return_um * 1e-3,
            ..Noise::default()
        };
        let mut network = network(&truth, nominal.clone(), 1, noise);
        network.visits = network
            .visits
            .iter()
            .flat_map(|visit| {
                visit.readings.clone().map(|r| Visit {
                    readings: r..r + 1,
                    ..visit.clone()
                })
            })
            .collect();
        let solution = solve(&network).unwrap();
        let mut largest = [0.0_f64; 3];
        for g in 0..network.groups.len() {
            let covariance = solution.covariance.block(g);
            for k in 0..9 {
                largest[k % 3] = largest[k % 3].max(covariance[(k, k)].sqrt() * 1e3);
            }
        }
        for (found, expected) in largest.iter().zip(expected) {
            assert!((found - expected).abs() < 0.02, "{largest:?} {expected:?}");
        }
    }
}

#[test]
fn what_is_missing_is_named() {
    let truth = truth(100.0);
    let full = network(&truth, truth.points.clone(), 1, Noise::default());

    let mut two_stations = full.clone();
    two_stations.visits.retain(|v| v.station < 2);
    two_stations
        .readings
        .truncate(two_stations.visits.last().unwrap().readings.end);
    let error = solve(&two_stations).unwrap_err();
    assert_eq!(error, Error::TooFewStations { need: 4, found: 2 });

    // Point 2 of group 5 is read from two stations only.
    let mut hidden = full.clone();
    hidden.readings.clear();
    for visit in &mut hidden.visits {
        let first = hidden.readings.len();
        let keep = |point| !(visit.group == 5 && point == 2 && visit.station < 2);
        let readings = &full.readings[visit.readings.clone()];
        hidden
            .readings
            .extend(readings.iter().filter(|r| keep(r.point)));
        visit.readings = first..hidden.readings.len();
    }
    let error = solve(&hidden).unwrap_err();
    assert_eq!(
        error,
        Error::PointSeenTooRarely {
            group: 5,
            point: 2,
            seen: 2,
            need: 3
        }
    );

    // All stations on one line: they can turn about it together with their dead paths.
    let mut aligned = truth;
    for (j, station) in aligned.stations.iter_mut().enumerate() {
        station.0 = Point3::new(-800.0 + 300.0 * j as f64, -900.0, 300.0);
    }
    let network = network(&aligned, aligned.points.clone(), 1, Noise::default());
    let error = solve(&network).unwrap_err();
    assert!(
        matches!(
            error,
            Error::StationsNotDetermined { .. } | Error::PointNotDetermined { .. }
        ),
        "{error}"
    );
}

fn small_noisy_network(seed: u64) -> (Network, Truth) {
    let truth = truth(100.0);
    let noise = Noise {
        length_sigma_mm: 3e-4,
        repeatability_mm: 1e-3,
        ..Noise::default()
    };
    let mut network = network(&truth, truth.points.clone(), 1, noise);
    add_noise(&mut network, &truth, &mut ChaCha8Rng::seed_from_u64(seed));
    (network, truth)
}

/// Solutions agree when no coordinate differs by more: 1e-6 of the least standard uncertainty
/// here, the tolerance of the iteration.
const SAME_MM: f64 = 1e-9;

fn assert_same(a: &Solution, b: &[Point3<f64>]) {
    for (p, q) in a.points_mm.iter().zip(b) {
        assert!((p - q).norm() < SAME_MM, "{p} {q}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn a_rigid_motion_of_the_nominal_points_moves_the_solution(
        seed in 0_u64..1000, axis in prop::array::uniform3(-1.0..1.0), shift in prop::array::uniform3(-2e3..2e3)
    ) {
        let (network, _) = small_noisy_network(seed);
        let motion = Isometry3::new(Vector3::from(shift), Vector3::from(axis));
        let mut moved = network.clone();
        moved.nominal_mm.iter_mut().for_each(|p| *p = motion * *p);
        let a = solve(&network).unwrap();
        let b = solve(&moved).unwrap();
        let expected: Vec<_> = a.points_mm.iter().map(|p| motion * p).collect();
        assert_same(&b, &expected);
        prop_assert!((a.sigma0() / b.sigma0() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn order_of_visits_and_readings_does_not_matter(seed in 0_u64..1000) {
        let (network, _) = small_noisy_network(seed);
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 77);
        let mut order: Vec<usize> = (0..network.visits.len()).collect();
        for i in (1..order.len()).rev() {
            order.swap(i, rng.random_range(0..=i));
        }
        let mut shuffled = network.clone();
        shuffled.visits.clear();
        shuffled.readings.clear();
        for v in order {
            let visit = &network.visits[v];
            let first = shuffled.readings.len();
            shuffled.readings.extend(network.readings[visit.readings.clone()].iter().rev());
            let readings = first..shuffled.readings.len();
            shuffled.visits.push(Visit { readings, ..visit.clone() });
        }
        let a = solve(&network).unwrap();
        let b = solve(&shuffled).unwrap();
        assert_same(&b, &a.points_mm);
    }

    #[test]
    fn order_of_stations_and_of_targets_does_not_matter(seed in 0_u64..1000) {
        let (network, _) = small_noisy_network(seed);
        let station = [2, 0, 3, 1];
        let target = [1, 2, 0];
        let mut relabelled = network.clone();
        for visit in &mut relabelled.visits {
            visit.station = station[visit.station];
        }
        for reading in &mut relabelled.readings {
            reading.point = target[reading.point];
        }
        for group in &network.groups {
            for (k, new) in target.into_iter().enumerate() {
                relabelled.nominal_mm[group.start + new] = network.nominal_mm[group.start + k];
            }
        }
        let a = solve(&network).unwrap();
        let b = solve(&relabelled).unwrap();
        for group in &network.groups {
            for (k, new) in target.into_iter().enumerate() {
                let (p, q) = (a.points_mm[group.start + k], b.points_mm[group.start + new]);
                prop_assert!((p - q).norm() < SAME_MM);
            }
        }
        for (j, new) in station.into_iter().enumerate() {
            let (p, q) = (a.stations[j], b.stations[new]);
            prop_assert!((p.position_mm - q.position_mm).norm() < 100.0 * SAME_MM);
        }
    }
}
