//! Stations whose lengths scatter more than those of the others, and axes that return worse.
//!
//! Told by how Baarda's w changes from one visit to the next, so that a zero that jumps or drifts, and lost motion, are
//! no scatter; and w knows what the adjustment keeps of each residual. That of a target leaves out what the machine does to all
//! lengths of a visit, which is what that of a visit shows. With `z` such a difference
//!
//! ```text
//! q_j = mean min(z², 9 s²)     s = median|z| / 0.6745     ln(q_j / q) has the variance 2/n + 2/N
//! ```
//!
//! where q is the median of the other stations or axes, n the visits of the one and N the fewest of the others: lengths of a visit
//! are taken as one observation.

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
    let squares = changes(network, &visits_of(network, station), |visit| {
        let residuals = &solution.residuals_mm[network.visits[visit].readings.clone()];
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
    let of_station = |j: usize| {
        Scatter::new(network, &visits_of(network, j), |visit| {
            let readings = network.visits[visit].readings.clone();
            readings.map(|i| tests.readings[i].w).collect()
        })
    };
    let scatters: Vec<Option<Scatter>> = (0..network.stations.len()).map(of_station).collect();
    uneven(&scatters)
}

/// How the visits to the groups of each axis scatter, over the mean of all visits, where those of one axis plainly scatter more
/// than those of the others, or where it is known that they do; one of an axis that tells nothing.
pub fn uneven_axes(
    network: &Network,
    solution: &Solution,
    (axes, axis_of_group): (usize, &[Option<usize>]),
    is_known: bool,
) -> Option<Vec<f64>> {
    let tests = solution.tests(network);
    let of_axis = |axis: usize| {
        let visits = network.visits.iter().enumerate();
        // One length does not tell its noise from the machine's.
        let own = visits.filter(|(_, visit)| {
            axis_of_group[visit.group] == Some(axis) && visit.readings.len() > 1
        });
        let own: Vec<usize> = own.map(|(number, _)| number).collect();
        Scatter::new(network, &own, |visit| vec![tests.visits[visit]])
    };
    let scatters: Vec<Option<Scatter>> = (0..axes).map(of_axis).collect();
    if !is_known && uneven(&scatters).is_empty() {
        return None;
    }
    let (mut sum, mut visits) = (0.0, 0.0);
    for own in scatters.iter().flatten() {
        sum += own.visits * own.variance;
        visits += own.visits;
    }
    let ratio = |own: &Option<Scatter>| own.as_ref().map_or(1.0, |own| own.variance * visits / sum);
    Some(scatters.iter().map(ratio).collect())
}

/// Those that plainly scatter more than the others, and the ratio of the variances.
fn uneven(scatters: &[Option<Scatter>]) -> Vec<(usize, f64)> {
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

/// What some visits scatter.
struct Scatter {
    /// Mean square of the differences of w.
    variance: f64,
    visits: f64,
}

impl Scatter {
    /// How the w of some visits change.
    fn new(network: &Network, visits: &[usize], w: impl Fn(usize) -> Vec<f64>) -> Option<Self> {
        Some(Self {
            variance: mean_without_jumps(changes(network, visits, w))?,
            visits: visits.len() as f64,
        })
    }
}

fn visits_of(network: &Network, station: usize) -> Vec<usize> {
    let visits = 0..network.visits.len();
    visits
        .filter(|&visit| network.visits[visit].station == station)
        .collect()
}

/// Squares of how some numbers of a visit change to the next of its station that reads the same points.
fn changes(network: &Network, visits: &[usize], of_visit: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    let read = |visit: usize| {
        let visit = &network.visits[visit];
        let readings = network.readings[visit.readings.clone()].iter();
        (visit.station, readings.map(|r| r.point))
    };
    let is_again = |two: &&[usize]| {
        let [(station, a), (next, b)] = [two[0], two[1]].map(read);
        station == next && a.eq(b)
    };
    let squares = visits.windows(2).filter(is_again).flat_map(|two| {
        let [a, b] = [two[0], two[1]].map(&of_visit);
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
