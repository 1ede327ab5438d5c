//! A jump of a zero that is not found, and what it does (external reliability, Baarda 1968).
//!
//! The test of a jump `c` ([`crate::jump_tests`]) finds it with a probability of 80 % where its size is at least
//!
//! ```text
//! ∇₀ = (z_{1-α/2} + z_{1-β}) / √(cᵀ M c)
//! ```
//!
//! with what the adjustment leaves of the whitened jump, `M c`. Where a station reads each stop once, the poses before
//! the instant and those after it share nothing but the stations: they absorb most of the jump, so that ∇₀ is many times
//! the noise, and moves them by many of their uncertainties. Stops that are read again show a jump as it is.

use std::collections::HashSet;

use trueaxis_leastsquares::dot;
use trueaxis_multilateration::{CHECKED_TOL, Network, Solution, Trials, Whitened};

use crate::reliability::with_power;
use crate::screened::Screened;
use crate::search::jump_limit;

/// Instants that are tried for each zero, and the fewest visits before and after one.
const INSTANTS: usize = 8;
const LEAST_VISITS: usize = 3;

/// Different stops per visit from which on most stops count as read once.
const READ_ONCE: f64 = 0.75;

/// With more groups no unnoticed jump does much: 1.5 uncertainties with 400 steps of an axis.
const MANY_GROUPS: usize = 1000;

/// A jump of a station's zero that is found with a probability of no more than 80 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unnoticed {
    /// The station.
    pub station: usize,
    /// First reading after the jump.
    pub first_reading: usize,
    /// The size of the jump, mm.
    pub jump_mm: f64,
    /// The group that it moves or turns most.
    pub group: usize,
    /// By how many standard uncertainties of that.
    pub in_u: f64,
}

impl Screened {
    /// The jump that does most without being found, where most stops were read once from each station.
    pub fn unnoticed_jump(&self) -> Option<Unnoticed> {
        let (network, solution) = (&self.network, &*self.solution);
        if network.groups.len() > MANY_GROUPS {
            return None;
        }
        let stops = network.visits.iter().map(|v| (v.station, v.group));
        let stops = stops.collect::<HashSet<_>>().len();
        if (stops as f64) < READ_ONCE * network.visits.len() as f64 {
            return None;
        }
        let u = uncertainties(network, solution);
        let rows = Whitened::new(network, solution);
        let trials = Trials::new(network, solution);
        let (mut workspace, mut errors_mm) = (trials.workspace(), vec![0.0; trials.errors()]);
        let detectable = with_power(jump_limit(network.readings.len()));
        let mut worst: Option<Unnoticed> = None;
        for ((station, first_reading), jump) in jumps(network) {
            let mut whitened = jump.clone();
            rows.whiten(&mut whitened);
            let mut left = whitened.clone();
            rows.project(&mut left);
            let kept = dot(&whitened, &left);
            if kept <= CHECKED_TOL * dot(&whitened, &whitened) {
                continue;
            }
            let jump_mm = detectable / kept.sqrt();
            for (error_mm, jump) in errors_mm.iter_mut().zip(&jump) {
                *error_mm = jump_mm * jump;
            }
            let moved = trials.solve(&errors_mm, &mut workspace);
            for (group, u) in u.iter().enumerate() {
                let changes = moved.group(group).iter().zip(u);
                let in_u = changes
                    .map(|(change, u)| (change / u).abs())
                    .fold(0.0, f64::max);
                if worst.is_none_or(|worst| in_u > worst.in_u) {
                    worst = Some(Unnoticed {
                        station,
                        first_reading,
                        jump_mm,
                        group,
                        in_u,
                    });
                }
            }
        }
        worst
    }
}

/// Standard uncertainties of the unknowns of each group.
fn uncertainties(network: &Network, solution: &Solution) -> Vec<Vec<f64>> {
    let noise = solution.noise();
    let of_group = |group: usize| {
        let (own, coupling) = noise.block(group);
        let through = (&coupling * noise.shared()).component_mul(&coupling);
        let variances = own.diagonal() + through.column_sum();
        variances.map(f64::sqrt).as_slice().to_vec()
    };
    (0..network.groups.len()).map(of_group).collect()
}

/// Unit jumps of the zeros: the station, the first reading, and an element for each reading.
fn jumps(network: &Network) -> impl Iterator<Item = ((usize, usize), Vec<f64>)> {
    let zeros = network.zero_of_readings();
    (0..network.zeros()).flat_map(move |zero| {
        let is_own = |i: &usize| zeros[*i] == zero;
        let own = network
            .visits
            .iter()
            .filter(|v| v.readings.clone().any(|i| is_own(&i)));
        let own: Vec<_> = own.collect();
        let first = (1..=INSTANTS).map(|k| own.len() * k / (INSTANTS + 1));
        let first = first.filter(|first| (*first).min(own.len() - first) >= LEAST_VISITS);
        let jump = |first: usize| {
            let mut jump = vec![0.0; zeros.len()];
            let after = own[first..].iter().flat_map(|visit| visit.readings.clone());
            after.filter(is_own).for_each(|i| jump[i] = 1.0);
            let visit = own[first];
            ((visit.station, visit.readings.start), jump)
        };
        first.map(jump).collect::<Vec<_>>()
    })
}
