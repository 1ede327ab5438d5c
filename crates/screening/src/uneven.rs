//! Lengths that scatter more than the others, of a station or of a part of the campaign, and axes that return worse.
//!
//! Scatter is how Baarda's w of a target changes from one visit of a station to the next: a zero that jumps or drifts
//! hardly enters, and w allows for what the adjustment absorbs of each residual, and for what the machine does to all
//! lengths of a visit. With `z` such a difference a station has
//!
//! ```text
//! q_j = mean min(z², 9 s²)     s = median|z| / 0.6745     ln(q_j / q) has the variance 2/n + 2/N
//! ```
//!
//! where q is the median of the other stations or axes, n the visits of the one and N the fewest of the others: lengths
//! of a visit are taken as one observation. A part of the campaign is judged by `y = ln mean z²` of the visits in it
//! against that of all others; a jump is one y of many.

use std::ops::Range;

use trueaxis_leastsquares::median;
use trueaxis_multilateration::{Network, Solution, solve_from};

use crate::estimate_noise::estimate_noise;
use crate::returns::Sweep;

/// Median of the amount of a standard normal variable.
const MEDIAN: f64 = 0.674_489_75;

/// Differences beyond this many standard deviations are jumps.
const JUMP: f64 = 3.0;

/// Standard deviations of the logarithm that chance reaches in one of a thousand campaigns, and the least ratio of variances that
/// matters.
const PLAIN: f64 = 3.5;
const MATTERS: f64 = 1.3;

/// Instants where a part may begin or end, its fewest visits, and the standard deviations of the difference of the means of y
/// that are beyond chance wherever it lies. Neighbouring changes share a visit: the variance of a mean is larger by a half.
const INSTANTS: usize = 96;
const LEAST_VISITS: usize = 12;
const PLAIN_PART: f64 = 5.0;
const SHARED: f64 = 1.5;
const MOST_PARTS: usize = 3;
const BEYOND: usize = 4;

/// By so much, in squares, a part, which may end anywhere, must be plainer than a whole station.
const AS_PLAIN: f64 = 12.0;

/// Rounds: the noise of all contains that of the lengths that scatter more, less each time.
const ROUNDS: usize = 4;

/// Lengths that plainly scatter more than the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Uneven {
    /// The stations that measured them.
    pub stations: Vec<usize>,
    /// Whether they are all of one station, or those of a part of the campaign.
    pub are_whole: bool,
    /// Ratio of the variances of w.
    pub ratio: f64,
    visits: Vec<usize>,
}

/// Gives lengths that scatter more than the others the factor on the variance of their own noise that explains it, and the solution with
/// them; which stations measured them. `declared` says whether the network's noise is more than a guess.
///
/// # Errors
/// Those of [`solve_from`].
pub fn weigh_uneven(
    network: &mut Network,
    solution: &mut Solution,
    declared: bool,
) -> Result<Vec<usize>, trueaxis_multilateration::Error> {
    let uneven = uneven_lengths(network, solution);
    if uneven.is_empty() {
        return Ok(Vec::new());
    }
    let mut factors: Vec<f64> = uneven.iter().map(|own| own.ratio).collect();
    let mut weighed = network.clone();
    for _ in 0..ROUNDS {
        weighed.variance_factors = factors_of_readings(network, &uneven, &factors);
        let mut solution = solve_from(&weighed, solution)?;
        estimate_noise(&mut weighed, &mut solution, declared)?;
        let own = weighed.noise.length_sigma_mm.powi(2);
        for (factor, uneven) in factors.iter_mut().zip(&uneven) {
            if let Some(variance) = own_variance(network, &solution, &uneven.visits) {
                *factor = (variance / own).max(1.0);
            }
        }
    }
    let weighed = uneven.iter().zip(&factors).filter(|(_, f)| **f > 1.0);
    let mut stations: Vec<usize> = weighed.flat_map(|(own, _)| own.stations.clone()).collect();
    stations.sort_unstable();
    stations.dedup();
    if !stations.is_empty() {
        network.variance_factors = factors_of_readings(network, &uneven, &factors);
        *solution = solve_from(network, solution)?;
    }
    Ok(stations)
}

/// Variance of the own noise of the lengths of some visits, mm², from how the differences within a visit change from one
/// visit to the next: they hardly contain what the machine does to all lengths. Helmert's contrasts
/// `√(k/(k+1)) (r_k - mean(r_0 … r_k-1))` have the variance of one length.
fn own_variance(network: &Network, solution: &Solution, visits: &[usize]) -> Option<f64> {
    let squares = changes(network, visits, |visit| {
        let residuals = &solution.residuals_mm[network.visits[visit].readings.clone()];
        let contrast = |k: usize| {
            let before = residuals[..k].iter().sum::<f64>() / k as f64;
            (k as f64 / (k + 1) as f64).sqrt() * (residuals[k] - before)
        };
        (1..residuals.len()).map(contrast).collect()
    });
    Scatter::of(squares, visits.len()).map(|own| 0.5 * own.variance)
}

/// Lengths that plainly scatter more than the others.
pub fn uneven_lengths(network: &Network, solution: &Solution) -> Vec<Uneven> {
    let tests = solution.tests(network);
    let w = |visit: usize| -> Vec<f64> {
        let readings = network.visits[visit].readings.clone();
        readings.map(|i| tests.readings[i].w).collect()
    };
    let stations = 0..network.stations.len();
    let mut of_stations: Vec<Vec<usize>> = stations.map(|j| visits_of(network, j)).collect();
    let mut all = parts(network, &of_stations, w);
    for own in &mut of_stations {
        own.retain(|visit| all.iter().all(|part| !part.visits.contains(visit)));
    }
    let scatter = |own: &Vec<usize>| Scatter::of(changes(network, own, w), own.len());
    let scatters: Vec<Option<Scatter>> = of_stations.iter().map(scatter).collect();
    all.extend(uneven(&scatters).into_iter().map(|(j, ratio)| Uneven {
        stations: vec![j],
        are_whole: true,
        ratio,
        visits: of_stations[j].clone(),
    }));
    all
}

fn visits_of(network: &Network, station: usize) -> Vec<usize> {
    let visits = network.visits.iter().enumerate();
    let own = visits.filter(|(_, visit)| visit.station == station);
    own.map(|(number, _)| number).collect()
}

/// Parts of the campaign whose lengths plainly scatter more.
fn parts(
    network: &Network,
    of_stations: &[Vec<usize>],
    w: impl Fn(usize) -> Vec<f64>,
) -> Vec<Uneven> {
    // y with the visit that it ends at, in measuring order.
    let mut all: Vec<(usize, f64)> = Vec::new();
    for own in of_stations {
        all.extend(own.windows(2).filter_map(|two| {
            let squares = changes(network, two, &w);
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            (mean > 0.0).then(|| (two[1], mean.ln()))
        }));
    }
    all.sort_unstable_by_key(|(visit, _)| *visit);
    let mut parts: Vec<Uneven> = Vec::new();
    while parts.len() < MOST_PARTS {
        let row = Row::new(&all);
        let Some((range, plain)) = row.scattered_part() else {
            break;
        };
        // A whole station that scatters as plainly is meant: it is no part.
        let of = |visit: usize| network.visits[visit].station;
        let plain_of = |station: usize| {
            let own = all.iter().filter(|(visit, _)| of(*visit) == station);
            let (count, sum) = own.fold((0, 0.0), |(n, sum), (_, y)| (n + 1, sum + y - row.mean));
            row.plain(count, sum)
        };
        let as_plain = |station: &usize| {
            plain_of(*station).is_some_and(|own| own * own > plain * plain - AS_PLAIN)
        };
        let station = (0..of_stations.len()).find(as_plain);
        if let Some(station) = station {
            all.retain(|(visit, _)| of(*visit) != station);
            continue;
        }
        let ratio = row.higher(range.len(), row.sums[range.end] - row.sums[range.start]);
        // Some visits beyond the ends are included: good ones do less harm than missing bad ones; y is of two visits.
        let first = all[range.start.saturating_sub(BEYOND)].0.saturating_sub(1);
        let last = all[(range.end - 1 + BEYOND).min(all.len() - 1)].0;
        let is_new = |visit: &usize| parts.iter().all(|part| !part.visits.contains(visit));
        let own: Vec<usize> = (first..=last).filter(is_new).collect();
        all.retain(|(visit, _)| !(first..=last).contains(visit));
        let mut stations: Vec<usize> = own.iter().map(|&visit| of(visit)).collect();
        stations.sort_unstable();
        stations.dedup();
        parts.push(Uneven {
            stations,
            are_whole: false,
            ratio: ratio.exp(),
            visits: own,
        });
    }
    parts
}

/// A row of y about its mean.
struct Row {
    mean: f64,
    /// Sums from its beginning.
    sums: Vec<f64>,
    squares: f64,
}

impl Row {
    fn new(all: &[(usize, f64)]) -> Self {
        let mean = all.iter().map(|(_, y)| y).sum::<f64>() / all.len() as f64;
        let mut sums = vec![0.0];
        for (_, y) in all {
            sums.push(sums[sums.len() - 1] + y - mean);
        }
        let squares = all.iter().map(|(_, y)| (y - mean).powi(2)).sum();
        Self {
            mean,
            sums,
            squares,
        }
    }

    /// By how much the mean of so many with this sum is above that of the others.
    fn higher(&self, inside: usize, sum: f64) -> f64 {
        let count = self.sums.len() - 1;
        sum * count as f64 / (inside * (count - inside)) as f64
    }

    /// The same in standard deviations; none for few, or most.
    fn plain(&self, inside: usize, sum: f64) -> Option<f64> {
        let count = self.sums.len() - 1;
        if inside < LEAST_VISITS || 2 * inside > count {
            return None;
        }
        let higher = self.higher(inside, sum);
        let variance = SHARED * (self.squares - higher * sum) / count as f64;
        let of_means = 1.0 / inside as f64 + 1.0 / (count - inside) as f64;
        (higher > MATTERS.ln()).then(|| higher / (variance * of_means).sqrt())
    }

    /// The part that is plainly the highest, and how plainly.
    fn scattered_part(&self) -> Option<(Range<usize>, f64)> {
        let count = self.sums.len() - 1;
        let instants = INSTANTS.min(count);
        let at = |k: usize| k * count / instants.max(1);
        let pairs = (0..instants).flat_map(|i| (i + 1..=instants).map(move |k| (i, k)));
        let plain = |part: Range<usize>| {
            let sum = self.sums[part.end] - self.sums[part.start];
            Some((part.clone(), self.plain(part.len(), sum)?))
        };
        let plainest = |parts: &mut dyn Iterator<Item = Range<usize>>| {
            parts.filter_map(plain).max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let (rough, _) = plainest(&mut pairs.map(|(i, k)| at(i)..at(k)))?;
        let near = |end: usize| {
            let step = count.div_ceil(instants);
            end.saturating_sub(step)..=(end + step).min(count)
        };
        let starts = near(rough.start);
        let mut parts = starts.flat_map(|a| near(rough.end).map(move |b| a..b.max(a)));
        plainest(&mut parts).filter(|(_, plain)| *plain > PLAIN_PART)
    }
}

/// The factor of each reading: its own times that of what it is of.
fn factors_of_readings(network: &Network, uneven: &[Uneven], factors: &[f64]) -> Vec<f64> {
    let readings = 0..network.readings.len();
    let mut all: Vec<f64> = readings.map(|i| network.variance_factor(i)).collect();
    for (own, factor) in uneven.iter().zip(factors) {
        for &visit in &own.visits {
            let readings = network.visits[visit].readings.clone();
            all[readings].iter_mut().for_each(|own| *own *= factor);
        }
    }
    all
}

/// Squares of how some numbers of a visit change to the next one that reads the same points.
fn changes(network: &Network, visits: &[usize], of_visit: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
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

/// Which plainly scatter more than the others, and the ratio of their variance to the median of the others.
pub fn uneven(scatters: &[Option<Scatter>]) -> Vec<(usize, f64)> {
    let of_one = |j: usize| {
        let own = scatters[j].as_ref()?;
        let others = || {
            let others = scatters.iter().enumerate().filter(|&(k, _)| k != j);
            others.filter_map(|(_, other)| other.as_ref())
        };
        let usual = median(&mut others().map(|other| other.variance).collect::<Vec<f64>>())?;
        let fewest = others()
            .map(|other| other.visits)
            .fold(f64::INFINITY, f64::min);
        let ratio = own.variance / usual;
        let u_ln = (2.0 / own.visits + 2.0 / fewest).sqrt();
        (usual > 0.0 && ratio > MATTERS && ratio.ln() > PLAIN * u_ln).then_some((j, ratio))
    };
    (0..scatters.len()).filter_map(of_one).collect()
}
