//! Stations whose lengths scatter more than those of the others.
//!
//! Told by how the residuals of a target change from one visit to the next, so that a zero that jumps or drifts, and lost motion,
//! are no scatter: with `z` such a difference over its standard deviation in the noise of all,
//!
//! ```text
//! q_j = mean min(z², 9 s²)     s = median|z| / 0.6745     ln(q_j / q) has the variance 2/n + 2/N
//! ```
//!
//! where q is the median of the other stations, n the visits of the station and N the fewest of the others. The three targets of
//! a visit are taken as one observation: what the machine does to them they have in common.

use trueaxis_leastsquares::median;
use trueaxis_multilateration::{Network, Solution};

/// Median of the amount of a standard normal variable.
const MEDIAN: f64 = 0.674_489_75;

/// Differences beyond this many standard deviations are jumps.
const JUMP: f64 = 3.0;

/// Standard deviations of the logarithm that chance reaches in one of a thousand campaigns, and the least ratio of variances that
/// matters.
const PLAIN: f64 = 3.5;
const MATTERS: f64 = 1.3;

/// Rounds: the noise of all contains that of the one.
const ROUNDS: usize = 4;

/// Variances of two visits that are not settled differ by more than this part.
const SETTLED: f64 = 0.1;

/// For each station the factor on the variance of its lengths' own noise that explains why they scatter more; one for most. The
/// solution is that of the network; `again` solves it with the factors of all readings, and estimates its noise.
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
    let given = network.variance_factors.clone();
    let mut network = network.clone();
    let mut ratios_now = ratios(&network, solution);
    for _ in 0..ROUNDS {
        for &(j, _) in &uneven {
            factors[j] = (factors[j] * ratios_now[j].of_own_noise(&network, factors[j])).max(1.0);
        }
        network.variance_factors = factors_of_readings(&network, &given, &factors);
        let solution = again(&mut network)?;
        ratios_now = ratios(&network, &solution);
        if uneven
            .iter()
            .all(|&(j, _)| (ratios_now[j].variances - 1.0).abs() < SETTLED)
        {
            break;
        }
    }
    Ok(factors)
}

/// Stations whose lengths plainly scatter more than those of the others, and the ratio of the variances. Where all readings have one
/// noise it does not depend on how large that is.
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

    /// By what the variance of the own noise grows, the machine's repeatability staying as it is.
    fn of_own_noise(self, network: &Network, factor: f64) -> f64 {
        let own = factor * network.noise.length_sigma_mm.powi(2);
        let machine = network.noise.repeatability_mm.powi(2);
        (self.variances * (own + machine) - machine) / own
    }
}

fn ratios(network: &Network, solution: &Solution) -> Vec<Ratio> {
    let scatters: Vec<Option<(f64, usize)>> = (0..network.stations.len())
        .map(|j| scatter(network, solution, j))
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
fn scatter(network: &Network, solution: &Solution, station: usize) -> Option<(f64, usize)> {
    let variance = |reading: usize| {
        let factor = network.variance_factor(reading);
        let own = factor * network.noise.length_sigma_mm.powi(2);
        own + network.noise.repeatability_mm.powi(2)
    };
    let visits = network
        .visits
        .iter()
        .filter(|visit| visit.station == station);
    let visits: Vec<_> = visits.collect();
    let mut squares = Vec::new();
    for two in visits.windows(2) {
        for (a, b) in two[0].readings.clone().zip(two[1].readings.clone()) {
            let is_same = network.readings[a].point == network.readings[b].point;
            let difference = solution.residuals_mm[b] - solution.residuals_mm[a];
            squares.extend(is_same.then(|| difference * difference / (variance(a) + variance(b))));
        }
    }
    let middle = median(&mut squares)?;
    let most = JUMP * JUMP * middle / (MEDIAN * MEDIAN);
    let sum: f64 = squares.iter().map(|square| square.min(most)).sum();
    Some((sum / squares.len() as f64, visits.len()))
}
