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
    let mut weighed = network.clone();
    for &(j, ratio) in &uneven {
        factors[j] = ratio;
    }
    for _ in 0..ROUNDS {
        if uneven.is_empty() {
            break;
        }
        weighed.variance_factors =
            factors_of_readings(network, &network.variance_factors, &factors);
        let solution = again(&mut weighed)?;
        let own = weighed.noise.length_sigma_mm.powi(2);
        for &(j, _) in &uneven {
            let variance = own_variance(network, &solution, j);
            factors[j] = variance
                .map_or(factors[j], |variance| variance / own)
                .max(1.0);
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
    let ratios = ratios(network, solution).into_iter().enumerate();
    let uneven = ratios.filter(|(_, ratio)| ratio.is_plain());
    uneven
        .map(|(station, ratio)| (station, ratio.variances))
        .collect()
}

/// The factor of each reading: its own times that of its station.
pub fn factors_of_readings(network: &Network, given: &[f64], of_stations: &[f64]) -> Vec<f64> {
    let mut factors = vec![1.0; network.readings.len()];
    for visit in &network.visits {
        for reading in visit.readings.clone() {
            factors[reading] =
                given.get(reading).copied().unwrap_or(1.0) * of_stations[visit.station];
        }
    }
    factors
}

/// What a station's lengths scatter beside those of the others.
#[derive(Clone, Copy)]
struct Ratio {
    /// Of the variances.
    variances: f64,
    /// Standard deviation of its logarithm.
    u_ln: f64,
}

impl Ratio {
    fn is_plain(self) -> bool {
        self.variances > MATTERS && self.variances.ln() > PLAIN * self.u_ln
    }
}

fn ratios(network: &Network, solution: &Solution) -> Vec<Ratio> {
    let tests = solution.tests(network);
    let scatters: Vec<Option<(f64, usize)>> = (0..network.stations.len())
        .map(|j| scatter(network, &tests, j))
        .collect();
    let ratio = |j: usize| {
        let others = || {
            scatters
                .iter()
                .enumerate()
                .filter(|(k, _)| *k != j)
                .filter_map(|(_, s)| *s)
        };
        let mut of_others: Vec<f64> = others().map(|(q, _)| q).collect();
        let fewest = others().map(|(_, visits)| visits).min().unwrap_or(0);
        let (Some((own, visits)), Some(usual)) = (scatters[j], median(&mut of_others)) else {
            return None;
        };
        let [visits, fewest] = [visits, fewest].map(|count| count.max(1) as f64);
        (usual > 0.0).then(|| Ratio {
            variances: own / usual,
            u_ln: (2.0 / visits + 2.0 / fewest).sqrt(),
        })
    };
    let none = Ratio {
        variances: 1.0,
        u_ln: f64::INFINITY,
    };
    (0..scatters.len())
        .map(|j| ratio(j).unwrap_or(none))
        .collect()
}

/// Mean square of the differences of a station, and its visits.
fn scatter(network: &Network, tests: &Tests, station: usize) -> Option<(f64, usize)> {
    let squares = changes(network, station, |readings| {
        readings.map(|i| tests.readings[i].w).collect()
    });
    let visits = network
        .visits
        .iter()
        .filter(|visit| visit.station == station);
    Some((mean_without_jumps(squares)?, visits.count()))
}

/// Squares of how some numbers of a visit change to the next of the station that reads the same points.
fn changes(
    network: &Network,
    station: usize,
    of_visit: impl Fn(Range<usize>) -> Vec<f64>,
) -> Vec<f64> {
    let visits = network
        .visits
        .iter()
        .filter(|visit| visit.station == station);
    let visits: Vec<&Visit> = visits.collect();
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
