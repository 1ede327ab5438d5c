//! Noise that grows with the length, though no part of it is declared to.
//!
//! With `y = ln mean z²` of how Baarda's w of the targets changes from one visit of a sweep to the next, and `x` the
//! logarithm of their distances, each less its mean over the sweep, `b = Σ x y / Σ x²` is zero for noise of any other
//! origin: of stations, axes or parts of the campaign that scatter more. Neighbouring y share a visit, so that the variance
//! of b is larger by a half. The part that grows is the one with which b vanishes. Where distances hardly change along a
//! sweep, all sweeps of an axis are taken together: a far station that only stands badly shows no b along its sweeps.

use trueaxis_multilateration::{Network, Noise, Solution, Tests, solve_from};

use super::{Axes, Sweep};
use crate::estimate_noise::estimate_noise;
use crate::uneven::changes;
use crate::{Error, Screened};

/// Standard deviations of b that chance reaches in one of thirty thousand campaigns.
const PLAIN: f64 = 4.0;

/// Standard deviations of b along the sweeps that must agree with b between them.
const AGREES: f64 = 2.0;

/// Fewest visits that tell.
const LEAST_VISITS: usize = 40;

/// Largest share of the variance at the usual distance that grows: more cannot be told from all.
const LARGEST_SHARE: f64 = 0.99;

/// Variance of b where neighbours share a visit, over that where they do not.
const SHARED: f64 = 1.5;

/// Steps towards the share, and the part of its standard deviation by chance to which b must vanish.
const STEPS: usize = 7;
const ENOUGH: f64 = 0.1;

impl Axes<'_> {
    /// The noise with the part proportional to the length that the lengths plainly show; none if there is no such part,
    /// or one is in the noise already. `together` is the result of [`screen_within`](crate::screen_within).
    pub fn noise_that_grows(&self, together: Result<&Screened, &Error>) -> Option<Noise> {
        let given = self.network.noise;
        if given.length_sigma_relative > 0.0 {
            return None;
        }
        let (found, _) = self.start(together)?;
        let distance_mm = usual_distance_mm(&found.network, &found.solution);
        let of_sweeps: Vec<Vec<&Sweep>> = self.sweeps.iter().map(|sweep| vec![sweep]).collect();
        let of_axis = |axis: usize| self.sweeps.iter().filter(move |sweep| sweep.axis == axis);
        let of_axes: Vec<Vec<&Sweep>> = (0..self.count).map(|a| of_axis(a).collect()).collect();
        let tests = found.tests();
        let grown = |alike: &[_]| growth(&found.network, (&found.solution, &tests), alike);
        let (along, across) = (grown(&of_sweeps)?, grown(&of_axes)?);
        let (first, alike) = match along.b > PLAIN * along.u {
            true => (along, of_sweeps),
            false if across.b > PLAIN * across.u && along.b > AGREES * along.u => (across, of_axes),
            false => return None,
        };
        // Between these shares b is positive and negative.
        let (mut low, mut high) = ((0.0, first.b), (1.0, first.b - 2.0));
        let estimated = |noise: Noise| {
            let mut network = Network {
                noise,
                ..found.network.clone()
            };
            let mut solution = solve_from(&network, &found.solution).ok()?;
            estimate_noise(&mut network, &mut solution, self.declared).ok()?;
            Some((network, solution))
        };
        let length_mm = found.network.noise.length_sigma_mm;
        let mut noise = given;
        for _ in 0..STEPS {
            let share = match high.1 < 0.0 {
                true => (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1),
                false => LARGEST_SHARE,
            };
            // From both sides.
            let share = share.clamp(0.9 * low.0 + 0.1 * high.0, 0.1 * low.0 + 0.9 * high.0);
            let share = share.min(LARGEST_SHARE);
            let (network, solution) = estimated(Noise {
                length_sigma_mm: length_mm * (1.0 - share).sqrt(),
                length_sigma_relative: length_mm * share.sqrt() / distance_mm,
                ..found.network.noise
            })?;
            noise = network.noise;
            let left = growth(&network, (&solution, &solution.tests(&network)), &alike)?;
            let is_most = share >= LARGEST_SHARE && left.b > 0.0;
            if is_most || left.b.abs() < ENOUGH * left.u {
                break;
            }
            match left.b > 0.0 {
                true => low = (share, left.b),
                false => high = (share, left.b),
            }
        }
        if !self.declared {
            return Some(noise);
        }
        // What is declared is kept, and the rest grows.
        let (network, _) = estimated(Noise {
            length_sigma_relative: noise.length_sigma_relative,
            ..given
        })?;
        Some(Noise {
            length_sigma_relative: network.noise.length_sigma_relative,
            ..given
        })
    }
}

/// How the logarithm of the variance of w grows with that of the distance.
struct Growth {
    b: f64,
    /// Its standard deviation by chance.
    u: f64,
}

/// The growth among sweeps that are alike otherwise; none where too little tells.
fn growth(
    network: &Network,
    (solution, tests): (&Solution, &Tests),
    alike: &[Vec<&Sweep>],
) -> Option<Growth> {
    let w = |visit: usize| -> Vec<f64> {
        let readings = network.visits[visit].readings.clone();
        readings.map(|reading| tests.readings[reading].w).collect()
    };
    let x = |visit: usize| {
        let distances_mm = distances_mm(network, solution, visit);
        let (sum, count) = distances_mm.fold((0.0, 0.0), |(sum, n), d| (sum + d.ln(), n + 1.0));
        sum / count
    };
    let (mut sum_xx, mut sum_xy, mut sum_yy, mut free) = (0.0, 0.0, 0.0, 0_usize);
    for sweeps in alike {
        let pairs = sweeps.iter().flat_map(|sweep| sweep.visits.windows(2));
        let pairs = pairs.filter_map(|two| {
            let squares = changes(network, two, w);
            let mean = squares.iter().sum::<f64>() / squares.len() as f64;
            (mean > 0.0).then(|| (0.5 * (x(two[0]) + x(two[1])), mean.ln()))
        });
        let pairs: Vec<(f64, f64)> = pairs.collect();
        let count = pairs.len() as f64;
        let mean_x = pairs.iter().map(|(x, _)| x).sum::<f64>() / count;
        let mean_y = pairs.iter().map(|(_, y)| y).sum::<f64>() / count;
        for (x, y) in &pairs {
            sum_xx += (x - mean_x).powi(2);
            sum_xy += (x - mean_x) * (y - mean_y);
            sum_yy += (y - mean_y).powi(2);
        }
        free += pairs.len().saturating_sub(1);
    }
    if free < LEAST_VISITS || sum_xx <= 0.0 {
        return None;
    }
    let b = sum_xy / sum_xx;
    let variance = SHARED * (sum_yy - b * sum_xy) / free as f64;
    Some(Growth {
        b,
        u: (variance / sum_xx).sqrt(),
    })
}

/// The distances of the lengths of a visit, mm.
fn distances_mm<'a>(
    network: &'a Network,
    solution: &'a Solution,
    visit: usize,
) -> impl Iterator<Item = f64> + 'a {
    let visit = &network.visits[visit];
    let station_mm = solution.stations[visit.station].position_mm;
    network.readings[visit.readings.clone()]
        .iter()
        .map(move |reading| {
            let point = network.point(visit.group, reading.point);
            (solution.points_mm[point] - station_mm).norm()
        })
}

/// Root mean square of all distances, mm.
fn usual_distance_mm(network: &Network, solution: &Solution) -> f64 {
    let visits = 0..network.visits.len();
    let squares = visits.flat_map(|visit| distances_mm(network, solution, visit).map(|d| d * d));
    (squares.sum::<f64>() / network.readings.len() as f64).sqrt()
}
