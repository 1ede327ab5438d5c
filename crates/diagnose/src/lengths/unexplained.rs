//! What is left when no effect explains it, in words.

use std::f64::consts::TAU;

use crate::lengths::base::{Adjusted, Base};

/// Periods that are tried in each turn: from the whole turn to this part of it.
const MOST_PERIODS: u32 = 60;
/// Steps between two whole numbers of periods.
const OVERSAMPLING: u32 = 4;
/// Probability of a peak from noise alone below which a period is worth a word.
const CLEAR: f64 = 1e-4;

/// The period in time that stands out of the residuals, s: the largest peak of the periodograms of all
/// stations together (Schuster's, on whitened residuals), if noise has none like it.
pub(crate) fn period_s(base: &Base<'_>, adjusted: &Adjusted) -> Option<f64> {
    let residuals = &adjusted.projection.residuals;
    let variance = adjusted.projection.squares() / adjusted.projection.degrees_of_freedom;
    let stations = base.scene.stations.len();
    let turn_s = (0..stations)
        .map(|station| {
            let own = base.readings.iter().filter(|r| r.station == station);
            let times = own.map(|r| r.time_s);
            let first = times.clone().fold(f64::INFINITY, f64::min);
            times.fold(f64::NEG_INFINITY, f64::max) - first
        })
        .fold(0.0, f64::max);
    if turn_s <= 0.0 {
        return None;
    }
    let tried = OVERSAMPLING..=OVERSAMPLING * MOST_PERIODS;
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
    let best = tried
        .clone()
        .max_by(|&a, &b| power(a).total_cmp(&power(b)))?;
    let tests = f64::from(MOST_PERIODS);
    let p = trueaxis_leastsquares::chi_squared_upper_tail(power(best), 2.0 * stations as f64);
    let clear = p * tests < CLEAR;
    clear.then(|| turn_s * f64::from(OVERSAMPLING) / f64::from(best))
}
