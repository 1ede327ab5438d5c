//! What the digits of the readings cannot show.
//!
//! A reading given in steps of δ is uncertain by `δ/√12` from them alone (JCGM 100:2008, F.2.2.1). Where a control
//! repeats to its last digit, nothing else remains of the noise.

use std::f64::consts::PI;

use trueaxis_leastsquares::last_digit;

/// Standard uncertainty of a reading from its last digit, µm. `None` if all readings are equal.
pub(crate) fn resolution_um(values_um: impl Iterator<Item = f64>) -> Option<f64> {
    last_digit(values_um).map(|digit| digit / 12_f64.sqrt())
}

/// The last digit of the readings, in the mean of a stop.
///
/// Rounding in steps of δ shifts the mean of noise of standard deviation σ; the variance of this over all places is
///
/// ```text
/// v(σ) = Σ_k δ²/(2π²k²) exp(-4π²k²σ²/δ²)     v(0) = δ²/12     s² = σ² + δ²/12 - v(σ)
/// ```
///
/// (B. Widrow, I. Kollár, Quantization Noise, 2008, ch. 4: characteristic function of the noise at multiples of
/// 2π/δ); `s²` is what repeats show. The readings of a stop are rounded alike where their noise is below the digit: of
/// `n` with the noise σ the mean has
///
/// ```text
/// r² = δ²/(12n) + (1 - 1/n) v(σ)
/// ```
///
/// from rounding, which is `δ²/12` where they agree, and an `n`-th of it for σ > δ/2, where `v` vanishes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digit {
    /// `δ²/12`, µm².
    rounding: f64,
    /// Variance of the noise of a reading within its stop, µm².
    within: f64,
    /// Mean of `1/n` over the stops.
    share: f64,
}

impl Digit {
    /// Of readings stop by stop, µm; `None` if all are equal.
    pub(crate) fn new(stops: &[&[f64]]) -> Option<Self> {
        let rounding = resolution_um(stops.iter().copied().flatten().copied())?.powi(2);
        let (mut squares, mut freedom, mut shares) = (0.0, 0.0, 0.0);
        for stop in stops {
            let share = 1.0 / stop.len() as f64;
            let mean = stop.iter().sum::<f64>() * share;
            squares += stop.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
            freedom += stop.len() as f64 - 1.0;
            shares += share;
        }
        let own = Self {
            rounding,
            within: 0.0,
            share: shares / stops.len() as f64,
        };
        let seen = squares / f64::max(freedom, 1.0);
        Some(Self {
            within: noise(seen, |noise| noise + rounding - own.common(noise)),
            ..own
        })
    }

    /// Standard uncertainty of the mean of a stop from the last digit, µm.
    pub(crate) fn of_stop_um(&self) -> f64 {
        let own = self.share * self.rounding;
        (own + (1.0 - self.share) * self.common(self.within)).sqrt()
    }

    /// The noise of a stop hidden by the last digit where `repeats` of it scatter by `scatter_um`, a standard
    /// deviation in µm: they are rounded alike; their mean seems too certain.
    ///
    /// `m` stops that scatter by `s` have a mean with the variance `v + s²/m`, as if each had `s² + m v`; here σ is
    /// that of all noise of a reading, within stops and from stop to stop.
    pub(crate) fn hidden_um(&self, scatter_um: f64, repeats: f64) -> f64 {
        let (rounding, scatter) = (self.of_stop_um().powi(2), scatter_um.powi(2));
        let common = |between: f64| self.common(between + self.within);
        let of_stop = self.share * self.within + rounding;
        let between = noise(scatter, |between| between + of_stop - common(between));
        let of_each = scatter + repeats * common(between);
        (of_each - scatter.max(rounding)).max(0.0).sqrt()
    }

    /// `v` for noise of this variance.
    fn common(&self, noise: f64) -> f64 {
        let term = |k: u32| {
            let waves = 2.0 * (PI * f64::from(k)).powi(2);
            12.0 * self.rounding / waves * (-2.0 * waves * noise / (12.0 * self.rounding)).exp()
        };
        (1..=TERMS).map(term).sum()
    }
}

/// Terms of the series: the next is below a thousandth of the first.
const TERMS: u32 = 32;

/// The variance of noise, between zero and all that is seen, for which as much is `expected` as is seen.
fn noise(seen: f64, expected: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, seen);
    for _ in 0..HALVINGS {
        let noise = 0.5 * (low + high);
        match expected(noise) > seen {
            true => high = noise,
            false => low = noise,
        }
    }
    high
}

/// They find σ² to a millionth.
const HALVINGS: u32 = 20;

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// The mean of rounded readings at a position anywhere between two digits, of five stops with one reading or
    /// three: its variance over 2000 positions is the noise that is seen and hidden, over the number of repeats,
    /// within four standard errors of such a variance.
    #[test]
    fn means_of_rounded_readings_are_as_uncertain_as_said() {
        let mut generator = ChaCha8Rng::seed_from_u64(12);
        let sizes = [0.0, 0.1, 0.2, 0.5];
        let all =
            sizes.map(|within| sizes.map(|between| [(within, between, 1), (within, between, 3)]));
        for (within, between, readings) in all.into_iter().flatten().flatten() {
            let (places, repeats) = (2000, 5);
            let (mut squares, mut scatter) = (0.0, 0.0);
            let mut stops = Vec::new();
            for _ in 0..places {
                let place: f64 = generator.random_range(-50.0..50.0);
                let mut noise = || (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0;
                let mut stop = || -> Vec<f64> {
                    let at = place + between * noise();
                    (0..readings)
                        .map(|_| (at + within * noise()).round())
                        .collect()
                };
                let own: Vec<Vec<f64>> = (0..repeats).map(|_| stop()).collect();
                let mean = |own: &Vec<f64>| own.iter().sum::<f64>() / own.len() as f64;
                let of_place = own.iter().map(mean).sum::<f64>() / f64::from(repeats);
                squares += (of_place - place).powi(2);
                scatter += own
                    .iter()
                    .map(|s| (mean(s) - of_place).powi(2))
                    .sum::<f64>();
                stops.extend(own);
            }
            let scatter = (scatter / f64::from(places * (repeats - 1))).sqrt();
            let stops: Vec<&[f64]> = stops.iter().map(Vec::as_slice).collect();
            let digit = Digit::new(&stops).unwrap();
            let hidden = digit.hidden_um(scatter, f64::from(repeats));
            let seen = scatter.max(digit.of_stop_um());
            let said = (seen * seen + hidden * hidden) / f64::from(repeats);
            let ratio = squares / f64::from(places) / said;
            let four = 4.0 * (2.0 / f64::from(places)).sqrt();
            assert!(
                (ratio - 1.0).abs() < four,
                "{within} {between} {readings}: {ratio}"
            );
        }
    }
}
