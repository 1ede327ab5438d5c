//! Report of what no effect explains.

use std::f64::consts::TAU;

use trueaxis_effects::Level;
use trueaxis_files::told_period;

use crate::Unexplained;
use crate::engine::{Omnibus, Suspect, unexplained};
use crate::lengths::adjusted::Adjusted;
use crate::lengths::base::Base;
use crate::numbers::{extremes, squares};

/// What is left beyond the noise, and what it varies with.
pub(crate) fn unexplained_part(
    base: &Base<'_>,
    current: &Adjusted,
    after: &[Omnibus],
    closest: Option<&(Suspect, f64)>,
) -> Unexplained {
    let dof = current.projection.degrees_of_freedom;
    let rms_um = (squares(&current.solution.residuals_mm) / dof).sqrt() * 1e3;
    let part = unexplained(Level::Lengths, &current.projection, after, rms_um);
    let mut note = match part.varies_with.as_slice() {
        [] => "more than one effect of the catalogue, and none alone".to_owned(),
        _ => part.note,
    };
    if let Some(period_s) = period_s(base, current) {
        note += &format!(
            ", strongest with a period of {}",
            told_period(period_s, "s")
        );
    }
    note += &of_stations(base, current);
    if let Some((suspect, share)) = closest {
        let id = suspect.hypothesis.effect.id;
        note += &format!(
            "; {id} comes closest and explains {:.0} % of it, which is not enough to name it",
            share * 100.0
        );
    }
    Unexplained { note, ..part }
}

/// Ratio of a station's residuals to those of the others from which the station is named.
const STANDS_OUT: f64 = 1.2;

fn of_stations(base: &Base<'_>, current: &Adjusted) -> String {
    let mut sums = vec![(0_usize, 0.0); base.scene.stations.len()];
    for (reading, e) in base.readings.iter().zip(&current.projection.residuals) {
        sums[reading.station].0 += 1;
        sums[reading.station].1 += e * e;
    }
    let mut rms: Vec<(f64, usize)> = sums
        .iter()
        .enumerate()
        .map(|(station, (count, squares))| ((squares / (*count).max(1) as f64).sqrt(), station))
        .collect();
    rms.sort_by(|a, b| b.0.total_cmp(&a.0));
    match rms.as_slice() {
        [first, second, ..] if first.0 > STANDS_OUT * second.0 => {
            format!(", largest from station {}", base.scene.stations[first.1])
        }
        _ => String::new(),
    }
}

/// Fewest and most periods to try in each occupation.
const LEAST_PERIODS: u32 = 2;
const MOST_PERIODS: u32 = 60;
/// Distance, in periods per repeat, within which a period belongs to the plan of repeats.
const OF_THE_PLAN: f64 = 0.1;
/// Grid points between two whole numbers of periods.
const OVERSAMPLING: u32 = 4;
/// Largest probability of a peak by noise alone for which a period is named.
const CLEAR: f64 = 1e-4;

/// The period in time that stands out in the residuals, s: the largest peak of the periodograms of all stations
/// together (Schuster's, of whitened residuals), if noise does not explain it.
fn period_s(base: &Base<'_>, adjusted: &Adjusted) -> Option<f64> {
    let residuals = &adjusted.projection.residuals;
    let variance = adjusted.projection.squares() / adjusted.projection.degrees_of_freedom;
    let stations = base.scene.stations.len();
    let turn_s = (0..stations)
        .map(|station| {
            let own = base.readings.iter().filter(|r| r.station == station);
            let [first, last] = extremes(own.map(|r| r.time_s));
            last - first
        })
        .fold(0.0, f64::max);
    if turn_s <= 0.0 {
        return None;
    }
    // A trend has most of its power in the first periods of an occupation, and changes from repeat to repeat in those
    // of the repeats: neither means that anything is periodic.
    let repeats = base.readings.iter().map(|r| r.repeat).max().unwrap_or(1);
    let of_the_plan = |k: u32| {
        let per_repeat = f64::from(k) / f64::from(OVERSAMPLING * repeats);
        repeats > 1 && (per_repeat - per_repeat.round()).abs() < OF_THE_PLAN && per_repeat < 2.5
    };
    let longest = OVERSAMPLING * LEAST_PERIODS;
    let tried = longest..=OVERSAMPLING * MOST_PERIODS;
    let power = |k: u32| -> f64 {
        let frequency = TAU * f64::from(k) / (f64::from(OVERSAMPLING) * turn_s);
        let mut sums = vec![(0.0, 0.0, 0_usize); stations];
        for (reading, e) in base.readings.iter().zip(residuals) {
            let (sin, cos) = (frequency * reading.time_s).sin_cos();
            let sum = &mut sums[reading.station];
            *sum = (sum.0 + e * cos, sum.1 + e * sin, sum.2 + 1);
        }
        let powers = sums
            .iter()
            .map(|(c, s, n)| (c * c + s * s) / (*n).max(1) as f64);
        // Chi-squared with two degrees of freedom for each station.
        2.0 * powers.sum::<f64>() / variance
    };
    let powers = tried.map(|k| (k, power(k)));
    let (best, largest) = powers.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if best == longest || of_the_plan(best) {
        return None;
    }
    let tests = f64::from(MOST_PERIODS);
    let p = trueaxis_leastsquares::chi_squared_upper_tail(largest, 2.0 * stations as f64);
    let clear = p * tests < CLEAR;
    clear.then(|| turn_s * f64::from(OVERSAMPLING) / f64::from(best))
}
