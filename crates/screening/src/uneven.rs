//! Lengths that scatter more than the others, of a station, a target or a part of the campaign, and axes that return worse.
//!
//! Scatter is how Baarda's w of a target changes from one visit of a station to the next: a zero that jumps or drifts
//! hardly enters, and w allows for what the adjustment absorbs of each residual, and for what the machine does to all
//! lengths of a visit. With `z` such a difference a station has
//!
//! ```text
//! q_j = mean min(z², 9 s²)     s = median|z| / 0.6745     ln(q_j / q) has the variance 2/n + 2/N
//! ```
//!
//! where q is the median of the other stations, targets or axes, n the visits of the one and N the fewest of the others:
//! lengths of a visit are taken as one observation.

mod parts;
mod targets;

use trueaxis_leastsquares::median;
use trueaxis_multilateration::{Network, Solution, Tests, solve_from};

use crate::estimate_noise::estimate_noise;
use crate::returns::Sweep;
use crate::uneven::parts::parts;
pub(crate) use crate::uneven::targets::place_of;
use crate::uneven::targets::{ratio_of_target, uneven_targets};

/// Median of the amount of a standard normal variable.
const MEDIAN: f64 = 0.674_489_75;

/// Differences beyond this many standard deviations are jumps.
const JUMP: f64 = 3.0;

/// Standard deviations of the logarithm that chance reaches in one of a thousand campaigns, and the least ratio of variances that
/// matters.
const PLAIN: f64 = 3.5;
const MATTERS: f64 = 1.3;

/// Most rounds, in each of which the noise of all contains less of that of the one, and the ratio of variances at which they end.
const ROUNDS: usize = 12;
const EVEN: f64 = 1.05;

/// What lengths that scatter more have in common.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Whose {
    /// They are all of a station.
    Station(usize),
    /// They are of a part of the campaign, from these stations.
    Part(Vec<usize>),
    /// They are all to a target: the body, and the place on it.
    Target((usize, usize)),
}

/// Lengths that plainly scatter more than the others.
#[derive(Debug, Clone, PartialEq)]
struct Uneven {
    /// What they have in common.
    whose: Whose,
    /// Ratio of the variances of w.
    ratio: f64,
    /// Its logarithm in standard deviations.
    plain: f64,
    /// The visits that read them, ascending.
    visits: Vec<usize>,
}

impl Uneven {
    fn has(&self, visit: usize) -> bool {
        self.visits.binary_search(&visit).is_ok()
    }
}

/// A network in which lengths that scatter more than the others have the factor on the variance of their own noise that
/// explains it.
#[derive(Debug, Clone)]
pub struct Weighed {
    /// The network with these factors.
    pub network: Network,
    /// Which lengths have a factor.
    pub uneven: Vec<LessWeight>,
}

/// Lengths with less weight.
#[derive(Debug, Clone, PartialEq)]
pub struct LessWeight {
    /// What they have in common.
    pub whose: Whose,
    /// The factor on the variance of their own noise.
    pub factor: f64,
}

/// Gives lengths that scatter more than the others less weight, by the tests at a solution; `None` if there are none.
/// `declared` says whether the network's noise is more than a guess.
pub fn weigh_uneven(
    network: &Network,
    (solution, tests): (&Solution, &Tests),
    declared: bool,
) -> Result<Option<Weighed>, trueaxis_multilateration::Error> {
    let uneven = uneven_lengths(network, tests);
    if uneven.is_empty() {
        return Ok(None);
    }
    let mut factors: Vec<f64> = uneven.iter().map(|own| own.ratio).collect();
    let mut weighed = network.clone();
    for _ in 0..ROUNDS {
        weighed.variance_factors = factors_of_readings(network, &uneven, &factors);
        let mut solution = solve_from(&weighed, solution)?;
        estimate_noise(&mut weighed, &mut solution, declared)?;
        let tests = solution.tests(&weighed);
        let w = |reading: usize| tests.readings[reading].w;
        let ratios = uneven
            .iter()
            .map(|own| ratio_to_rest(network, &uneven, own, w));
        let ratios: Vec<f64> = ratios.map(|ratio| ratio.unwrap_or(1.0)).collect();
        for (factor, ratio) in factors.iter_mut().zip(&ratios) {
            *factor = (*factor * ratio).max(1.0);
        }
        if ratios.iter().all(|ratio| ratio.ln().abs() < EVEN.ln()) {
            break;
        }
    }
    let weighed = uneven.iter().zip(&factors).filter(|(_, f)| **f > 1.0);
    let own = weighed.map(|(own, &factor)| LessWeight {
        whose: own.whose.clone(),
        factor,
    });
    let own: Vec<LessWeight> = own.collect();
    if own.is_empty() {
        return Ok(None);
    }
    let network = Network {
        variance_factors: factors_of_readings(network, &uneven, &factors),
        ..network.clone()
    };
    Ok(Some(Weighed {
        network,
        uneven: own,
    }))
}

/// Ratio of the variance of w of some lengths to that of those that do not scatter more.
fn ratio_to_rest(
    network: &Network,
    uneven: &[Uneven],
    own: &Uneven,
    w: impl Fn(usize) -> f64,
) -> Option<f64> {
    if let Whose::Target(place) = own.whose {
        return ratio_of_target(network, place, w);
    }
    let of_visit = |visit: usize| network.visits[visit].readings.clone().map(&w).collect();
    let scatter = |is_in: &dyn Fn(&usize) -> bool| {
        let of_station = |j: usize| {
            let mut visits = visits_of(network, j);
            visits.retain(is_in);
            changes(network, &visits, of_visit)
        };
        let squares: Vec<f64> = (0..network.stations.len()).flat_map(of_station).collect();
        let count = squares.len();
        Scatter::of(squares, count)
    };
    let rest = scatter(&|visit| uneven.iter().all(|own| !own.has(*visit)))?;
    let own = scatter(&|visit| own.has(*visit))?;
    (rest.variance > 0.0).then_some(own.variance / rest.variance)
}

/// Lengths that plainly scatter more than the others: to targets, or of stations and parts of the campaign. Each makes
/// the other seem uneven: the noise of a target shows more from some stations than from others.
fn uneven_lengths(network: &Network, tests: &Tests) -> Vec<Uneven> {
    let w_of = |reading: usize| tests.readings[reading].w;
    let w = |visit: usize| -> Vec<f64> {
        let readings = network.visits[visit].readings.clone();
        readings.map(w_of).collect()
    };
    let stations = 0..network.stations.len();
    let mut of_stations: Vec<Vec<usize>> = stations.map(|j| visits_of(network, j)).collect();
    let mut all = parts(network, &of_stations, w);
    for own in &mut of_stations {
        own.retain(|visit| all.iter().all(|part| !part.has(*visit)));
    }
    let scatter = |own: &Vec<usize>| Scatter::of(changes(network, own, w), own.len());
    let scatters: Vec<Option<Scatter>> = of_stations.iter().map(scatter).collect();
    all.extend(uneven(&scatters).into_iter().map(|own| Uneven {
        whose: Whose::Station(own.number),
        ratio: own.ratio,
        plain: own.plain,
        visits: of_stations[own.number].clone(),
    }));
    let of_targets = uneven_targets(network, w_of);
    let plainest = |all: &[Uneven]| all.iter().map(|own| own.plain).fold(0.0, f64::max);
    match plainest(&of_targets) > plainest(&all) {
        true => of_targets,
        false => all,
    }
}

fn visits_of(network: &Network, station: usize) -> Vec<usize> {
    let visits = network.visits.iter().enumerate();
    let own = visits.filter(|(_, visit)| visit.station == station);
    own.map(|(number, _)| number).collect()
}

/// The factor of each reading: its own times that of what it is of.
fn factors_of_readings(network: &Network, uneven: &[Uneven], factors: &[f64]) -> Vec<f64> {
    let readings = 0..network.readings.len();
    let mut all: Vec<f64> = readings.map(|i| network.variance_factor(i)).collect();
    for (own, factor) in uneven.iter().zip(factors) {
        for &visit in &own.visits {
            for reading in network.visits[visit].readings.clone() {
                let is_own = match own.whose {
                    Whose::Target(place) => place_of(network, visit, reading) == Some(place),
                    _ => true,
                };
                if is_own {
                    all[reading] *= factor;
                }
            }
        }
    }
    all
}

/// Squares of how some numbers of a visit change to the next one that reads the same points.
pub(crate) fn changes(
    network: &Network,
    visits: &[usize],
    of_visit: impl Fn(usize) -> Vec<f64>,
) -> Vec<f64> {
    let points = |visit: usize| {
        let readings = &network.readings[network.visits[visit].readings.clone()];
        readings.iter().map(|r| r.point)
    };
    let two = visits.windows(2);
    let two = two.filter(|two| points(two[0]).eq(points(two[1])));
    let squares = two.flat_map(|two| {
        let [a, b] = [two[0], two[1]].map(&of_visit);
        let squares = a.into_iter().zip(b).map(|(a, b)| (b - a).powi(2));
        squares.collect::<Vec<f64>>()
    });
    squares.collect()
}

/// How the visits of the sweeps of each axis scatter, over the mean of all visits, where those of one axis plainly scatter
/// more than those of the others, or are known to; 1 for an axis that shows nothing.
pub fn uneven_axes(
    network: &Network,
    solution: &Solution,
    (axes, sweeps): (usize, &[Sweep]),
    is_known: bool,
) -> Option<Vec<f64>> {
    let w = solution.tests(network).visits;
    // One length does not tell its noise from the machine's.
    let tells = |visit: &usize| network.visits[*visit].readings.len() > 1;
    let of_sweep = |sweep: &Sweep| {
        let visits = sweep.visits.iter().copied().filter(tells);
        let w: Vec<f64> = visits.map(|visit| w[visit]).collect();
        // Lost motion changes along the axis.
        let changes = w.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).powi(2));
        changes.collect::<Vec<f64>>()
    };
    let of_axis = |axis: usize| {
        let own = sweeps.iter().filter(|sweep| sweep.axis == axis);
        let squares: Vec<f64> = own.flat_map(of_sweep).collect();
        let count = squares.len();
        Scatter::of(squares, count)
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

/// What some visits scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Mean square of what changes from one visit to the next, without jumps.
    pub variance: f64,
    visits: f64,
}

impl Scatter {
    /// Of the squares of these changes.
    pub fn of(mut squares: Vec<f64>, visits: usize) -> Option<Self> {
        let middle = median(&mut squares)?;
        let most = JUMP * JUMP * middle / (MEDIAN * MEDIAN);
        let sum: f64 = squares.iter().map(|square| square.min(most)).sum();
        Some(Self {
            variance: sum / squares.len() as f64,
            visits: visits as f64,
        })
    }
}

/// One that scatters more than the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoreScatter {
    /// Which.
    pub number: usize,
    /// Ratio of its variance to the median of the others.
    pub ratio: f64,
    /// Its logarithm in standard deviations.
    pub plain: f64,
}

/// Which plainly scatter more than the others.
pub fn uneven(scatters: &[Option<Scatter>]) -> Vec<MoreScatter> {
    let of_one = |number: usize| {
        let (ratio, u_ln) = ratio_to_others(scatters, number)?;
        let plain = ratio.ln() / u_ln;
        (ratio > MATTERS && plain > PLAIN).then_some(MoreScatter {
            number,
            ratio,
            plain,
        })
    };
    (0..scatters.len()).filter_map(of_one).collect()
}

/// Ratio of the variance of one to the median of the others, and the standard uncertainty of its logarithm.
fn ratio_to_others(scatters: &[Option<Scatter>], j: usize) -> Option<(f64, f64)> {
    let own = scatters[j].as_ref()?;
    let others = || {
        let others = scatters.iter().enumerate().filter(|&(k, _)| k != j);
        others.filter_map(|(_, other)| other.as_ref())
    };
    let usual = median(&mut others().map(|other| other.variance).collect::<Vec<f64>>())?;
    let fewest = others()
        .map(|other| other.visits)
        .fold(f64::INFINITY, f64::min);
    let u_ln = (2.0 / own.visits + 2.0 / fewest).sqrt();
    (usual > 0.0).then_some((own.variance / usual, u_ln))
}
