//! What the repeats of a stop have in common is no noise of single lengths.
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

use nalgebra::DVector;
use trueaxis_leastsquares::f_upper_tail;
use trueaxis_multilateration::{Network, Solution, Visit, Whitened};

use crate::estimate_noise::TOO_GOOD;

/// Degrees of freedom on either side below which nothing is said.
const LEAST_DEGREES: f64 = 10.0;

/// Probability at which repeats are said to have more in common than by chance: one clean campaign in a thousand.
const LEVEL: f64 = 1e-3;

/// The largest ratio of mean squares that is stated.
const MOST_RATIO: f64 = 1e6;

/// What repeats have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alike {
    /// Rms of what all repeats have in common over that of how they differ, each of a length in units of its noise.
    pub ratio: f64,
    /// Factor by which the standard deviation of a mean over repeats is larger than the noise of all residuals says.
    pub factor: f64,
    /// Probability of as much from noise.
    pub p_value: f64,
}

/// What the repeats of a network have in common, if more than by chance; `rows` are those of its visits.
pub fn alike(network: &Network, solution: &Solution, rows: &Whitened) -> Option<Alike> {
    let stop = |visit: &Visit| (visit.station, visit.group, points(network, visit));
    let mut of_stop: HashMap<_, Vec<&Visit>> = HashMap::new();
    for visit in &network.visits {
        of_stop.entry(stop(visit)).or_default().push(visit);
    }
    let (mut within, mut of_within) = (0.0, 0.0);
    // In the order of measuring: sums of floating-point numbers depend on it.
    for visit in &network.visits {
        let repeats = &of_stop[&stop(visit)];
        if repeats.len() > 1 && repeats[0].readings == visit.readings {
            within += differences(rows, repeats);
            of_within += ((repeats.len() - 1) * visit.readings.len()) as f64;
        }
    }
    let (squares, all) = solution.of_lengths(network);
    let of_rest = all - of_within;
    let is_few = of_within < LEAST_DEGREES || of_rest < LEAST_DEGREES;
    if is_few || squares < TOO_GOOD.powi(2) * all {
        return None;
    }
    let rest = (squares - within) / of_rest;
    // Repeats may be equal to the last digit.
    let ratio = (rest / (within / of_within)).min(MOST_RATIO);
    let p_value = f_upper_tail(ratio, of_rest, of_within);
    (p_value < LEVEL).then(|| Alike {
        ratio: ratio.sqrt(),
        factor: (rest / (squares / all)).sqrt(),
        p_value,
    })
}

/// The points of a visit, in the order of its rows.
pub(crate) fn points(network: &Network, visit: &Visit) -> Vec<usize> {
    let readings = network.readings[visit.readings.clone()].iter();
    let mut points: Vec<usize> = readings.map(|reading| reading.point).collect();
    points.sort_unstable();
    points
}

/// `Σ (v_i - v̄)ᵀ C⁻¹ (v_i - v̄)` of visits of one stop, which have the same weights.
fn differences(rows: &Whitened, repeats: &[&Visit]) -> f64 {
    let residuals =
        |visit: &&Visit| DVector::from_column_slice(&rows.residuals[visit.readings.clone()]);
    let all: Vec<DVector<f64>> = repeats.iter().map(residuals).collect();
    let mean = all.iter().sum::<DVector<f64>>() / all.len() as f64;
    all.iter().map(|x| (x - &mean).norm_squared()).sum()
}
