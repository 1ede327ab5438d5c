//! What the adjustment leaves of errors in the lengths, and the tests that follow from it, against their definitions.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Vector3};
use trueaxis_kinematics::centroid;
use trueaxis_multilateration::{Network, Noise, Reflectors, Solution, Whitened, contrast, solve};

use crate::irregular::{dead_path_of_readings, network};

pub(crate) const NOISE: Noise = Noise {
    length_sigma_mm: 3e-4,
    length_sigma_relative: 5e-7,
    repeatability_mm: 1e-3,
};

/// So few groups are one chunk of work, so many are several.
pub(crate) const FEW: usize = 21;
const MANY: usize = 600;

/// A network with errors of micrometres, solved.
pub(crate) fn solved(groups: usize, noise: Noise, is_tied: bool) -> (Network, Solution) {
    let mut network = network(groups, noise, is_tied);
    for (i, reading) in network.readings.iter_mut().enumerate() {
        reading.length_mm += 2e-3 * (3.3 * (i as f64 + 0.7)).sin();
    }
    let solution = solve(&network).unwrap();
    assert!(solution.termination.is_converged());
    (network, solution)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[test]
fn residuals_are_what_is_left() {
    for is_tied in [false, true] {
        let (network, solution) = solved(FEW, NOISE, is_tied);
        let rows = Whitened::new(&network, &solution);
        let mut left = rows.residuals.clone();
        rows.project(&mut left);
        for (left, residual) in left.iter().zip(&rows.residuals) {
            assert!((left - residual).abs() < 1e-3, "not at the minimum");
        }
        let squares = dot(&rows.residuals, &rows.residuals);
        assert!((squares / solution.squares - 1.0).abs() < 1e-9);
        let mut whitened = solution.residuals_mm.clone();
        rows.whiten(&mut whitened);
        for (found, expected) in whitened.iter().zip(&rows.residuals) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
}

/// `W C Wᵀ = 1` of each visit, with the covariance by its definition.
#[test]
fn weights_whiten_the_covariance() {
    for is_tied in [false, true] {
        let (network, solution) = solved(FEW, NOISE, is_tied);
        let rows = Whitened::new(&network, &solution);
        for visit in &network.visits {
            let own = visit.readings.clone();
            let column = |reading: usize| {
                let mut error = vec![0.0; network.readings.len()];
                error[reading] = 1.0;
                rows.whiten(&mut error);
                DVector::from_column_slice(&error[own.clone()])
            };
            let w = DMatrix::from_columns(&own.clone().map(column).collect::<Vec<_>>());
            let beam = |reading: usize| {
                let first = network.groups[visit.group].start;
                let point = first + network.readings[reading].point;
                solution.points_mm[point] - solution.stations[visit.station].position_mm
            };
            let covariance = |i: usize, j: usize| {
                let [a, b] = [i, j].map(|k| beam(own.start + k));
                let common = NOISE.repeatability_mm.powi(2) * a.normalize().dot(&b.normalize());
                let alone = NOISE.length_sigma_at_mm(a.norm()).powi(2)
                    * network.variance_factors[own.start + i];
                common + if i == j { alone } else { 0.0 }
            };
            let whitened = &w * DMatrix::from_fn(own.len(), own.len(), covariance) * w.transpose();
            let off = whitened - DMatrix::identity(own.len(), own.len());
            assert!(off.amax() < 1e-12, "{visit:?}: {off}");
        }
    }
}

/// Where everything is, apart from the equations.
#[derive(Clone)]
pub(crate) struct Places {
    stations: Vec<Point3<f64>>,
    dead_paths_mm: Vec<f64>,
    pub(crate) points: Vec<Point3<f64>>,
    constants_mm: Vec<f64>,
}

impl Places {
    pub(crate) fn of(solution: &Solution) -> Self {
        let dead_paths = solution.stations.iter().map(|s| s.dead_path_mm);
        Self {
            stations: solution.stations.iter().map(|s| s.position_mm).collect(),
            dead_paths_mm: dead_paths
                .chain(solution.dead_paths_after_mm.clone())
                .collect(),
            points: solution.points_mm.clone(),
            constants_mm: solution.reflectors_mm.clone(),
        }
    }

    pub(crate) fn lengths_mm(&self, network: &Network) -> Vec<f64> {
        let reflectors: &Reflectors = network.reflectors.as_ref().unwrap();
        let dead_paths = dead_path_of_readings(network);
        let visits = network.visits.iter();
        let readings = visits.flat_map(|visit| visit.readings.clone().map(move |i| (visit, i)));
        let length = readings.map(|(visit, i)| {
            let point = network.groups[visit.group].start + network.readings[i].point;
            (self.points[point] - self.stations[visit.station]).norm()
                - self.dead_paths_mm[dead_paths[i]]
                + self.constants_mm[reflectors.of_points[point]]
        });
        length.collect()
    }
}

/// A change of what is unknown, by so many mm (angles by a thousandth of it in rad).
type Change = Box<dyn Fn(&mut Places, f64)>;

/// Every way in which the unknowns move the solution.
fn changes(network: &Network, solution: &Solution) -> Vec<(String, Change)> {
    let mut all: Vec<(String, Change)> = Vec::new();
    let mut add = |name: String, change: Change| all.push((name, change));
    for axis in 0..3 {
        let along = Vector3::ith(axis, 1.0);
        for station in 0..network.stations.len() {
            add(
                format!("station {station} along {axis}"),
                Box::new(move |places, step| places.stations[station] += along * step),
            );
        }
        for (number, group) in network.groups.iter().enumerate() {
            let group = group.clone();
            let is_tied = network
                .bodies
                .as_ref()
                .is_some_and(|bodies| bodies.of_groups[number].body.is_some());
            if !is_tied {
                for point in group {
                    add(
                        format!("point {point} along {axis}"),
                        Box::new(move |places, step| places.points[point] += along * step),
                    );
                }
                continue;
            }
            for (shift, turn) in [(along, Vector3::zeros()), (Vector3::zeros(), along)] {
                let group = group.clone();
                add(
                    format!("pose {number} by {shift} and {turn}"),
                    Box::new(move |places, step| {
                        let points = &mut places.points[group.clone()];
                        let centre = centroid(points);
                        let motion = Isometry3::new(shift * step, turn * (1e-3 * step));
                        for point in points {
                            *point = centre + motion * (*point - centre) + shift * step;
                        }
                    }),
                );
            }
        }
    }
    let dead_paths = network.stations.len() + network.interruptions.len();
    for dead_path in 0..dead_paths {
        add(
            format!("dead path {dead_path}"),
            Box::new(move |places, step| places.dead_paths_mm[dead_path] += step),
        );
    }
    for m in 0..2 {
        let change = move |places: &mut Places, step: f64| {
            for (reflector, constant) in places.constants_mm.iter_mut().enumerate() {
                *constant += step * contrast(reflector, m);
            }
        };
        add(format!("contrast {m}"), Box::new(change));
    }
    if let Some(bodies) = network.bodies.clone() {
        // One target of the body, in the stage's own axes.
        for axis in 0..3 {
            let (bodies, poses) = (bodies.clone(), solution.poses.clone());
            let groups = network.groups.clone();
            let change = move |places: &mut Places, step: f64| {
                for (number, group) in groups.iter().enumerate() {
                    if bodies.of_groups[number].body.is_some() {
                        places.points[group.start + 1] +=
                            poses[number].rotation * Vector3::ith(axis, step);
                    }
                }
            };
            add(format!("shape along {axis}"), Box::new(change));
        }
    }
    all
}

/// Derivatives of the lengths by differences: those of every unknown are absorbed, and one of no unknown is not. (That none is
/// too large or too small shows in the covariances, and where trials meet full solutions.)
#[test]
fn what_an_unknown_does_to_the_lengths_is_absorbed() {
    const STEP: f64 = 0.1;
    for is_tied in [false, true] {
        let (network, solution) = solved(FEW, NOISE, is_tied);
        let rows = Whitened::new(&network, &solution);
        let left_of = |mut column: Vec<f64>| {
            rows.whiten(&mut column);
            let size = dot(&column, &column);
            rows.project(&mut column);
            dot(&column, &column) / size
        };
        let changes = changes(&network, &solution);
        assert!(changes.len() > 100);
        let start = Places::of(&solution);
        for (name, change) in &changes {
            let [plus, minus] = [STEP, -STEP].map(|step| {
                let mut places = start.clone();
                change(&mut places, step);
                places.lengths_mm(&network)
            });
            let column = plus.iter().zip(&minus).map(|(a, b)| a - b).collect();
            let left = left_of(column);
            assert!(left < 1e-9, "{name}: {left}");
        }
        // One target of one step moves against all others.
        let mut places = start;
        let before = places.lengths_mm(&network);
        places.points[0].x += STEP;
        let after = places.lengths_mm(&network);
        let column = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let left = left_of(column);
        assert_eq!(left > 0.1, is_tied, "{left}");
    }
}

/// Baarda's w, redundancy number and estimated error of every reading from its unit error.
#[test]
fn tests_of_single_lengths_are_those_of_their_definition() {
    // Without a common repeatability the weights are single numbers, and what is kept of an error is its redundancy.
    let independent = Noise {
        repeatability_mm: 0.0,
        ..NOISE
    };
    for (noise, is_tied) in [
        (NOISE, false),
        (NOISE, true),
        (independent, false),
        (independent, true),
    ] {
        let (network, solution) = solved(FEW, noise, is_tied);
        let rows = Whitened::new(&network, &solution);
        let let_go = solution.tests_of_inflated(&network, &network.variance_factors);
        let as_weighed = solution.tests(&network);
        let places = Places::of(&solution);
        let distances = places.lengths_mm(&network);
        let dead_paths = dead_path_of_readings(&network);
        for i in 0..network.readings.len() {
            let mut error = vec![0.0; network.readings.len()];
            error[i] = 1.0;
            rows.whiten(&mut error);
            let mut left = error.clone();
            rows.project(&mut left);
            let kept = dot(&error, &left);
            let distance_mm = distances[i] + places.dead_paths_mm[dead_paths[i]];
            let own = noise.length_sigma_at_mm(distance_mm).powi(2);
            let inflated = own * (network.variance_factors[i] - 1.0);
            let found = as_weighed.readings[i];
            for (found, inflated) in [(found, 0.0), (let_go.readings[i], inflated)] {
                let variance = 1.0 / kept - inflated;
                let w = dot(&error, &rows.residuals) / kept / variance.sqrt();
                assert!((found.w - w).abs() < 1e-4, "{i}: {found:?} {w}");
                let ratio = found.sigma_mm / variance.sqrt();
                assert!((ratio - 1.0).abs() < 1e-5, "{i}: {found:?} {ratio}");
            }
            if noise == independent {
                let redundancy = kept / dot(&error, &error);
                assert!(
                    (found.redundancy - redundancy).abs() < 1e-9,
                    "{i}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn redundancy_numbers_add_up() {
    for (groups, is_tied) in [(FEW, false), (FEW, true), (MANY, true)] {
        let (network, solution) = solved(groups, NOISE, is_tied);
        let readings = solution.tests(&network).readings.into_iter();
        let sum: f64 = readings.map(|reading| reading.redundancy).sum();
        let degrees_of_freedom = solution.degrees_of_freedom() as f64;
        assert!(
            (sum / degrees_of_freedom - 1.0).abs() < 1e-9,
            "{sum} {degrees_of_freedom}"
        );
    }
}
