//! Stations whose lengths scatter more than those of the others.
//!
//! Told by how Baarda's w of a target changes from one visit to the next, so that a zero that jumps or drifts, and lost motion, are
//! no scatter; and w knows what the adjustment keeps of each residual, and leaves out what the machine does to all lengths of
//! a visit. With `z` such a difference
//!
//! ```text
//! q_j = mean min(z², 9 s²)     s = median|z| / 0.6745     ln(q_j / q) has the variance 2/n + 2/N
//! ```
//!
//! where q is the median of the other stations, n the visits of the station and N the fewest of the others: lengths of a visit
//! are taken as one observation.

use std::ops::Range;

use trueaxis_leastsquares::median;
use trueaxis_multilateration::{Network, Solution, Tests, Visit};

/// Median of the amount of a standard normal variable.
const MEDIAN: f64 = 0.674_489_75;

/// Differences beyond this many standard deviations are jumps.
const JUMP: f64 = 3.0;

/// Standard deviations of the logarithm that chance reaches in one of a thousand campaigns, and the least ratio of variances that
/// matters.
const PLAIN: f64 = 3.5;
const MATTERS: f64 = 1.3;

/// Rounds: the noise of all contains that of the one, less each time.
const ROUNDS: usize = 4;

/// For each station the factor on the variance of its lengths' own noise that explains why they scatter more; one for most. `again`
/// solves the network with the factors of its readings and estimates its noise.
///
/// # Errors
/// Those of `again`.
pub fn station_factors<E>(
    network: &Network,
    solution: &Solution,
    mut again: impl FnMut(&mut Network) -> Result<Solution, E>,
) -> Result<Vec<f64>, E> {
    let mut factors = vec![1.0; network.stations.len()];
    let uneven = uneven_stations(network, solution);
    if uneven.is_empty() {
        return Ok(factors);
    }
    for &(j, ratio) in &uneven {
        factors[j] = ratio;
    }
    let mut weighed = network.clone();
    for _ in 0..ROUNDS {
        weighed.variance_factors = factors_of_readings(network, &factors);
        let solution = again(&mut weighed)?;
        let own = weighed.noise.length_sigma_mm.powi(2);
        for &(j, _) in &uneven {
            if let Some(variance) = own_variance(network, &solution, j) {
                factors[j] = (variance / own).max(1.0);
            }
        }
    }
    Ok(factors)
}

/// Variance of the own noise of a station's lengths, mm²: of how the differences within a visit change from one visit to the next, in which
/// what the machine does to all lengths is hardly left. Helmert's contrasts `√(k/(k+1)) (r_k - mean(r_0 … r_k-1))` have that of one
/// length.
fn own_variance(network: &Network, solution: &Solution, station: usize) -> Option<f64> {
    let squares = changes(network, station, |readings| {
        let residuals = &solution.residuals_mm[readings];
        let contrast = |k: usize| {
            let before = residuals[..k].iter().sum::<f64>() / k as f64;
            (k as f64 / (k + 1) as f64).sqrt() * (residuals[k] - before)
        };
        (1..residuals.len()).map(contrast).collect()
    });
    mean_without_jumps(squares).map(|mean| 0.5 * mean)
}

/// Stations whose lengths plainly scatter more than those of the others, and the ratio of the variances of w.
pub fn uneven_stations(network: &Network, solution: &Solution) -> Vec<(usize, f64)> {
    let tests = solution.tests(network);
    let scatters = (0..network.stations.len()).map(|j| scatter(network, &tests, j));
    let scatters: Vec<Option<Scatter>> = scatters.collect();
    let uneven = |j: usize| {
        let own = scatters[j].as_ref()?;
        let others = || {
            (0..scatters.len())
                .filter(|&k| k != j)
                .filter_map(|k| scatters[k].as_ref())
        };
        let usual = median(&mut others().map(|other| other.variance).collect::<Vec<f64>>())?;
        let fewest = others()
            .map(|other| other.visits)
            .fold(f64::INFINITY, f64::min);
        let ratio = own.variance / usual;
        let u_ln = (2.0 / own.visits + 2.0 / fewest).sqrt();
        (usual > 0.0 && ratio > MATTERS && ratio.ln() > PLAIN * u_ln).then_some((j, ratio))
    };
    (0..scatters.len()).filter_map(uneven).collect()
}

/// The factor of each reading: its own times that of its station.
pub fn factors_of_readings(network: &Network, of_stations: &[f64]) -> Vec<f64> {
    let mut factors = vec![1.0; network.readings.len()];
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            factors[reading] = network.variance_factor(reading) * of_stations[visit.station];
        }
    }
    factors
}

/// What the lengths of a station scatter.
struct Scatter {
    /// Mean square of the differences of w.
    variance: f64,
    visits: f64,
}

fn scatter(network: &Network, tests: &Tests, station: usize) -> Option<Scatter> {
    let squares = changes(network, station, |readings| {
        readings.map(|i| tests.readings[i].w).collect()
    });
    Some(Scatter {
        variance: mean_without_jumps(squares)?,
        visits: visits_of(network, station).count() as f64,
    })
}

fn visits_of(network: &Network, station: usize) -> impl Iterator<Item = &Visit> {
    network
        .visits
        .iter()
        .filter(move |visit| visit.station == station)
}

/// Squares of how some numbers of a visit change to the next of the station that reads the same points.
fn changes(
    network: &Network,
    station: usize,
    of_visit: impl Fn(Range<usize>) -> Vec<f64>,
) -> Vec<f64> {
    let visits: Vec<&Visit> = visits_of(network, station).collect();
    let points = |visit: &Visit| {
        network.readings[visit.readings.clone()]
            .iter()
            .map(|r| r.point)
    };
    let two = visits
        .windows(2)
        .filter(|two| points(two[0]).eq(points(two[1])));
    let squares = two.flat_map(|two| {
        let [a, b] = [two[0], two[1]].map(|visit| of_visit(visit.readings.clone()));
        a.into_iter()
            .zip(b)
            .map(|(a, b)| (b - a).powi(2))
            .collect::<Vec<f64>>()
    });
    squares.collect()
}

fn mean_without_jumps(mut squares: Vec<f64>) -> Option<f64> {
    let middle = median(&mut squares)?;
    let most = JUMP * JUMP * middle / (MEDIAN * MEDIAN);
    let sum: f64 = squares.iter().map(|square| square.min(most)).sum();
    Some(sum / squares.len() as f64)
}
