//! The standard deviations of Table 1, by Monte Carlo and from the covariance.
//!
//! A trial of *one measurement* draws the errors of all lengths and solves for all points. A trial
//! of the *mean of ten* does so ten times and averages the coordinates, as section 4 of the paper
//! says ("averaging the measurement results of x, y, and z").

use nalgebra::{DMatrix, Point3};
use serde::Serialize;
use trueaxis_montecarlo::{ChaCha8Rng, Model, Propagation, Settings, Trials as Count, propagate};
use trueaxis_multilateration::{Noise, Solution, Trials, Workspace, solve};

use super::arrangement::{Arrangement, TARGETS, network};

/// Standard deviation of a length, µm.
pub(crate) const LENGTH_SIGMA_UM: f64 = 0.269;

/// What is measured how often.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Measurement {
    /// Standard deviation per coordinate of the position that the machine returns to, µm.
    pub(crate) repeatability_um: f64,
    /// Measurements that are averaged.
    pub(crate) repeats: u32,
}

/// The largest standard deviation of x, of y and of z over all points.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Figures {
    /// By Monte Carlo, µm.
    pub(crate) monte_carlo_um: [f64; 3],
    /// Standard errors of these at the points where they were found, µm.
    pub(crate) standard_error_um: [f64; 3],
    /// From the covariance of the adjustment, µm.
    pub(crate) analytic_um: [f64; 3],
}

/// The figures of one row of the table.
pub(crate) fn figures(
    points_mm: &[Point3<f64>],
    arrangement: &Arrangement,
    measurement: Measurement,
    trials: usize,
    seed: u64,
) -> anyhow::Result<Figures> {
    let (solution, found) = measure(points_mm, arrangement, measurement, trials, seed)?;
    let largest = [0, 1, 2].map(|axis| {
        let outputs = &found.outputs[axis * points_mm.len()..][..points_mm.len()];
        let largest = outputs.iter().max_by(|a, b| a.u.total_cmp(&b.u));
        largest.map_or([f64::NAN; 2], |one| {
            [one.u, one.scatter.u].map(|mm| mm * 1e3)
        })
    });
    let averaged = f64::from(measurement.repeats).sqrt();
    Ok(Figures {
        monte_carlo_um: largest.map(|[u_um, _]| u_um),
        standard_error_um: largest.map(|[_, scatter_um]| scatter_um),
        analytic_um: largest_sigmas_mm(&solution).map(|sigma_mm| sigma_mm * 1e3 / averaged),
    })
}

/// Measures the points from the stations several times: the solution of one measurement, with its
/// covariance, and the distributions of x of all points, then y, then z, less that solution, mm.
pub(crate) fn measure(
    points_mm: &[Point3<f64>],
    arrangement: &Arrangement,
    measurement: Measurement,
    trials: usize,
    seed: u64,
) -> anyhow::Result<(Solution, Propagation)> {
    let noise = Noise {
        length_sigma_mm: LENGTH_SIGMA_UM * 1e-3,
        repeatability_mm: measurement.repeatability_um * 1e-3,
        ..Noise::default()
    };
    let network = network(points_mm, &arrangement.stations_mm, noise);
    let solution = solve(&network)?;
    let model = Measured {
        trials: Trials::new(&network, &solution),
        repeats: measurement.repeats,
    };
    let settings = Settings {
        trials: Count::Fixed(trials),
        seed,
        ..Settings::default()
    };
    let found = propagate(&model, &settings, &|_| {})?;
    Ok((solution, found))
}

/// The largest standard deviation of x, y and z over all points.
pub(crate) fn largest_sigmas_mm(solution: &Solution) -> [f64; 3] {
    let sigmas_mm = sigmas_mm(solution);
    [0, 1, 2].map(|axis| sigmas_mm.iter().map(|p| p[axis]).fold(0.0, f64::max))
}

/// The standard deviations of x, y and z of each point, from the covariance of its step.
pub(crate) fn sigmas_mm(solution: &Solution) -> Vec<[f64; 3]> {
    let of_step = |covariance: DMatrix<f64>| {
        let of_target = move |target: usize| {
            [0, 1, 2]
                .map(|axis| 3 * target + axis)
                .map(|k| covariance[(k, k)].sqrt())
        };
        (0..TARGETS).map(of_target)
    };
    solution.covariance.blocks().flat_map(of_step).collect()
}

/// The mean of some measurements.
struct Measured {
    trials: Trials,
    repeats: u32,
}

struct Storage {
    errors_mm: Vec<f64>,
    trial: Workspace,
}

impl Model for Measured {
    type Workspace = Storage;

    fn outputs(&self) -> usize {
        3 * self.trials.points()
    }

    fn workspace(&self) -> Storage {
        Storage {
            errors_mm: vec![0.0; self.trials.errors()],
            trial: self.trials.workspace(),
        }
    }

    fn trial(&self, rng: &mut ChaCha8Rng, storage: &mut Storage, outputs: &mut [f64]) {
        outputs.fill(0.0);
        let share = f64::from(self.repeats).recip();
        for _ in 0..self.repeats {
            self.trials.draw(rng, &mut storage.errors_mm);
            let corrections = self.trials.solve(&storage.errors_mm, &mut storage.trial);
            let points_mm = corrections.points_mm();
            let coordinates = (0..3).flat_map(|axis| points_mm.iter().map(move |p| p[axis]));
            for (output, coordinate) in outputs.iter_mut().zip(coordinates) {
                *output += share * coordinate;
            }
        }
    }
}
