//! A part of the campaign whose lengths scatter more: `y = ln mean z²` of the visits in it is higher than that of all others. A
//! jump is one y of many.

use std::ops::Range;

use trueaxis_multilateration::Network;

use crate::uneven::{MATTERS, Uneven, Whose, changes};

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

/// Parts of the campaign whose lengths plainly scatter more.
pub(super) fn parts(
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
        // What is as plain of a whole station is of that.
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
        // What scatters a little beyond its ends does more harm than what weighs less there; y is of two visits.
        let first = all[range.start.saturating_sub(BEYOND)].0.saturating_sub(1);
        let last = all[(range.end - 1 + BEYOND).min(all.len() - 1)].0;
        let is_new = |visit: &usize| parts.iter().all(|part| !part.has(*visit));
        let own: Vec<usize> = (first..=last).filter(is_new).collect();
        all.retain(|(visit, _)| !(first..=last).contains(visit));
        let mut stations: Vec<usize> = own.iter().map(|&visit| of(visit)).collect();
        stations.sort_unstable();
        stations.dedup();
        parts.push(Uneven {
            whose: Whose::Part(stations),
            ratio: ratio.exp(),
            plain,
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

    /// Mean of a part of `inside` values with this sum, less the mean of the others.
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
