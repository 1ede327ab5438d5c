//! Misfits that change slowly from step to step.
//!
//! Drifts, slips and stirring air make the errors of neighbouring steps alike, so that the mean of n of them is less
//! certain than that of n independent ones. The whitened residuals of a station at a step are averaged over both sides of
//! approach and all repeats: lost motion, of which a pose takes the mean, is not in these means, and those of noise are
//! independent. With these means, x, times the root of the number of visits, over the stations, runs and targets
//!
//! ```text
//! ρ = Σ x_i x_i+1 / Σ x_i²     z = ρ √N ~ N(0, 1) without correlation     Λ = Σ_runs (Σ x_i)² / Σ x_i²
//! ```
//!
//! for N pairs of neighbours. What the adjustment takes from the residuals makes z and Λ a little smaller. Results that
//! sum over all steps of a run, as squareness does, have Λ times the variance that independent errors give them; those
//! of a single step do not.

use std::collections::HashMap;

use nalgebra::DVector;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_multilateration::{Network, Whitened};

use crate::alike::points;
use crate::estimate_noise::TOO_GOOD;

/// Probability at which steps are said to be alike: less than one clean campaign in a thousand.
const LEVEL: f64 = 1e-3;

/// How far the misfits of the steps of a run are alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slow {
    /// Correlation of neighbouring steps.
    pub correlation: f64,
    /// Probability of as much from noise.
    pub p_value: f64,
    /// Λ for a whole run.
    pub ratio: f64,
}

/// How far the misfits of steps are alike, if more than by chance; `rows` are those of the network's visits, `runs` groups
/// in the order of their steps.
pub fn slow(network: &Network, rows: &Whitened, runs: &[Vec<usize>]) -> Option<Slow> {
    let means = means(network, rows);
    let (mut squares, mut count, mut of_sums) = (0.0, 0.0, 0.0);
    let (mut of_neighbours, mut pairs) = (0.0, 0.0);
    let of_stations =
        (0..network.stations.len()).flat_map(|j| runs.iter().map(move |run| (j, run)));
    for (station, run) in of_stations {
        let mut steps = run.iter().filter_map(|group| means.get(&(station, *group)));
        let Some(first) = steps.next() else {
            continue;
        };
        let mut sum = first.of_visit();
        squares += sum.norm_squared();
        count += sum.len() as f64;
        let mut before = sum.clone();
        // A step with other points does not belong to the row.
        for x in steps
            .filter(|step| step.points == first.points)
            .map(Mean::of_visit)
        {
            squares += x.norm_squared();
            count += x.len() as f64;
            of_neighbours += before.dot(&x);
            pairs += x.len() as f64;
            sum += &x;
            before = x;
        }
        of_sums += sum.norm_squared();
    }
    let variance = squares / count;
    let correlation = of_neighbours / pairs / variance;
    // Lengths that were calculated have residuals of rounding.
    if correlation <= 0.0 || variance < TOO_GOOD * TOO_GOOD {
        return None;
    }
    let p_value = 0.5 * chi_squared_upper_tail(correlation.powi(2) * pairs, 1.0);
    let ratio = of_sums / squares;
    (p_value < LEVEL && ratio > 1.0).then_some(Slow {
        correlation,
        p_value,
        ratio,
    })
}

/// What a station's visits to a group have in the mean.
struct Mean {
    /// The points of the group that were read.
    points: Vec<usize>,
    /// Sum of the whitened residuals over the visits, and their number.
    sum: DVector<f64>,
    visits: f64,
}

impl Mean {
    /// With the variance of a single visit.
    fn of_visit(&self) -> DVector<f64> {
        &self.sum / self.visits.sqrt()
    }
}

/// The means for each station and group; visits that read other points than the first are left out.
fn means(network: &Network, rows: &Whitened) -> HashMap<(usize, usize), Mean> {
    let mut means: HashMap<(usize, usize), Mean> = HashMap::new();
    for visit in network.visits.iter().filter(|v| !v.readings.is_empty()) {
        let points = points(network, visit);
        let whitened = &rows.residuals[visit.readings.clone()];
        let mean = means.entry((visit.station, visit.group));
        let mean = mean.or_insert_with(|| Mean {
            sum: DVector::zeros(points.len()),
            points: points.clone(),
            visits: 0.0,
        });
        if mean.points == points {
            mean.sum += DVector::from_column_slice(whitened);
            mean.visits += 1.0;
        }
    }
    means
}
