//! What the repeats of a stop have alike is no noise of single lengths.
//!
//! Where a station reads the same stop again, the model predicts the same lengths, whatever its unknowns are. How the residuals `v` of the
//! repeats differ from their mean is therefore noise and nothing else; the rest of the sum of squares is noise and what is wrong with
//! the model:
//!
//! ```text
//! W = Σ (v_i - v̄)ᵀ C⁻¹ (v_i - v̄)      F = (S - W)/(f - f_W) / (W/f_W)
//! ```
//!
//! with `S` and `f` of the whole adjustment, and a degree of freedom of `f_W` for each length that repeats another (the lack of fit of
//! analysis of variance). The noise that is estimated from all residuals lies between the two.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector, Point3, Vector3};
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{Network, Solution, Visit};

/// Degrees of freedom on either side below which nothing is said.
const LEAST_DEGREES: f64 = 10.0;

/// Probability at which repeats are said to have more alike than chance gives them: one clean campaign in a thousand.
const LEVEL: f64 = 1e-3;

/// What repeats have alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alike {
    /// Rms of what all repeats have alike over that of how they differ, each of a single length in units of its noise.
    pub ratio: f64,
    /// By what the standard deviation of a mean over repeats is larger than the noise of all residuals says.
    pub factor: f64,
    /// Probability of as much from noise.
    pub p_value: f64,
}

/// What the repeats of a network have alike, if it is more than chance gives them.
pub fn alike(network: &Network, solution: &Solution) -> Option<Alike> {
    let stop = |visit: &Visit| (visit.station, points(network, visit));
    let mut of_stop: HashMap<(usize, Vec<usize>), Vec<&Visit>> = HashMap::new();
    for visit in &network.visits {
        of_stop.entry(stop(visit)).or_default().push(visit);
    }
    let (mut within, mut of_within) = (0.0, 0.0);
    // In the order of measuring: sums of floating-point numbers depend on it.
    for visit in &network.visits {
        let repeats = &of_stop[&stop(visit)];
        if repeats.len() > 1 && repeats[0].readings == visit.readings {
            within += differences(network, solution, repeats)?;
            of_within += ((repeats.len() - 1) * visit.readings.len()) as f64;
        }
    }
    let (squares, all) = solution.of_lengths(network);
    let of_rest = all - of_within;
    if of_within < LEAST_DEGREES || of_rest < LEAST_DEGREES || within <= 0.0 {
        return None;
    }
    let rest = (squares - within) / of_rest;
    let ratio = rest / (within / of_within);
    let p_value = f_upper_tail(ratio, of_rest, of_within);
    (p_value < LEVEL).then(|| Alike {
        ratio: ratio.sqrt(),
        factor: (rest / (squares / all)).sqrt(),
        p_value,
    })
}

/// The points of a visit.
fn points(network: &Network, visit: &Visit) -> Vec<usize> {
    let readings = network.readings[visit.readings.clone()].iter();
    readings
        .map(|reading| network.point(visit.group, reading.point))
        .collect()
}

/// `Σ (v_i - v̄)ᵀ C⁻¹ (v_i - v̄)` of visits of one stop.
fn differences(network: &Network, solution: &Solution, repeats: &[&Visit]) -> Option<f64> {
    let residuals =
        |visit: &&Visit| DVector::from_column_slice(&solution.residuals_mm[visit.readings.clone()]);
    let all: Vec<DVector<f64>> = repeats.iter().map(residuals).collect();
    let mean = all.iter().sum::<DVector<f64>>() / all.len() as f64;
    let factor = noise_of(network, solution, repeats[0]).cholesky()?;
    let of_one = |v: &DVector<f64>| {
        let difference = v - &mean;
        difference.dot(&factor.solve(&difference))
    };
    Some(all.iter().map(of_one).sum())
}

/// Covariance of the lengths of a visit, mm².
pub(crate) fn noise_of(network: &Network, solution: &Solution, visit: &Visit) -> DMatrix<f64> {
    let station_mm = solution.stations[visit.station].position_mm;
    let points = points(network, visit).into_iter();
    let places: Vec<Point3<f64>> = points.map(|p| solution.points_mm[p]).collect();
    let beams: Vec<Vector3<f64>> = places.iter().map(|place| place - station_mm).collect();
    let own = network.returns.as_ref().map(|all| all[visit.group]);
    let lever = |place: &Point3<f64>| own.map_or(0.0, |own| own.lever_mm(station_mm, *place));
    let levers: Vec<f64> = places.iter().map(lever).collect();
    let returns = network.noise.repeatability_mm.powi(2);
    let on_bed = network.bed == Some(visit.group);
    DMatrix::from_fn(beams.len(), beams.len(), |i, k| {
        let together = match on_bed {
            true => 0.0,
            false => {
                let displaced = beams[i].normalize().dot(&beams[k].normalize());
                returns
                    * (displaced * own.map_or(1.0, |own| own.variance_ratio)
                        + levers[i] * levers[k])
            }
        };
        let own = network.noise.length_sigma_at_mm(beams[i].norm()).powi(2);
        together + if i == k { own } else { 0.0 }
    })
}
