//! Turns of all targets together about a rotary axis at each visit.
//!
//! With the whitened column x of a turn about the axis at a visit, the whitened residuals v and what the adjustment leaves of x,
//!
//! ```text
//! q = xᵀv     e = xᵀMx     δ = q/e     var(δ) = 1/e + θ² - θ₀²     d_k = δ_k - (δ_k-1 + δ_k+1)/2
//! ```
//!
//! with the standard deviation θ of the angle at which the axis stops, and θ₀ in the noise of the network. Lost motion, which is part of
//! δ, is nearly a straight line over three visits of a sweep, and not in d. Gross errors hardly change the median of d² over its
//! variance for θ = θ₀, which is then that of χ²(1).

use trueaxis_leastsquares::{dot, median};
use trueaxis_multilateration::{Return, Whitened};

use super::{Axes, Sweep};
use crate::Screened;

/// Median of χ² with one degree of freedom.
const MEDIAN: f64 = 0.454_936;

/// Standard deviation of the median of d² over sweeps, relative to it, times the root of their number.
const OF_MEDIAN: f64 = 2.8;

/// Differences d below which nothing is said.
const LEAST_DIFFERENCES: usize = 12;

/// Part of a turn below which the lengths do not show it.
const VISIBLE: f64 = 1e-6;

/// How large the turns of an axis are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turns {
    /// By how much the ratio of their variance to that of the noise exceeds one.
    pub(super) excess: f64,
    /// Standard deviation of that by chance.
    pub(super) chance: f64,
    /// Median of e.
    pub(super) part: f64,
}

/// A turn about its axis at a visit.
struct Turn {
    q: f64,
    e: f64,
}

/// The turns of each axis along its sweeps.
pub(super) fn turns(screened: &Screened, axes: &Axes<'_>) -> Vec<Option<Turns>> {
    let whitened = Whitened::new(&screened.network, &screened.solution);
    let of_sweep = |sweep: &Sweep| {
        let visits = sweep.visits.iter();
        let turns = visits.filter_map(|&visit| Turn::of(visit, screened, &whitened, &axes.lines));
        turns.collect::<Vec<Turn>>()
    };
    let of_axis = |axis: usize| {
        let own = axes.sweeps.iter().filter(|sweep| sweep.axis == axis);
        of_sweeps(&own.map(of_sweep).collect::<Vec<_>>())
    };
    (0..axes.count).map(of_axis).collect()
}

impl Turn {
    /// That of a visit to a group which a rotary axis moves, if the lengths show it.
    fn of(
        number: usize,
        screened: &Screened,
        whitened: &Whitened,
        lines: &[Option<Return>],
    ) -> Option<Self> {
        let (network, solution) = (&screened.network, &screened.solution);
        let visit = &network.visits[number];
        let (rows, line) = (visit.readings.clone(), lines[visit.group]?);
        let station_mm = solution.stations[visit.station].position_mm;
        let lever = |i: usize| {
            let point = network.point(visit.group, network.readings[i].point);
            line.lever_mm(station_mm, solution.points_mm[point])
        };
        let mut x: Vec<f64> = rows.clone().map(lever).collect();
        whitened.whiten_from(number, &mut x);
        let mut own = vec![0.0; whitened.own_width];
        let mut shared = vec![0.0; whitened.shared_width];
        let (mut q, mut whole) = (0.0, 0.0);
        for (row, &x) in rows.clone().zip(&x) {
            q += x * whitened.residuals[row];
            whole += x * x;
            whitened.add_row(row, x, &mut own, &mut shared);
        }
        let through = whitened.reduced_inverse.chunks_exact(shared.len());
        let absorbed = through
            .zip(&shared)
            .map(|(row, s)| s * dot(row, &shared))
            .sum::<f64>();
        let e = whole - dot(&own, &own) - absorbed;
        (e > VISIBLE * whole).then_some(Self { q, e })
    }
}

fn of_sweeps(sweeps: &[Vec<Turn>]) -> Option<Turns> {
    let threes = sweeps.iter().flat_map(|turns| turns.windows(3));
    let squares = threes.map(|three| {
        let [a, b, c] = [&three[0], &three[1], &three[2]];
        let difference = b.q / b.e - 0.5 * (a.q / a.e + c.q / c.e);
        difference.powi(2) / (1.0 / b.e + 0.25 * (1.0 / a.e + 1.0 / c.e))
    });
    let mut squares: Vec<f64> = squares.collect();
    if squares.len() < LEAST_DIFFERENCES {
        return None;
    }
    Some(Turns {
        excess: median(&mut squares)? / MEDIAN - 1.0,
        chance: OF_MEDIAN / (squares.len() as f64).sqrt(),
        part: median(
            &mut sweeps
                .iter()
                .flatten()
                .map(|turn| turn.e)
                .collect::<Vec<f64>>(),
        )?,
    })
}
