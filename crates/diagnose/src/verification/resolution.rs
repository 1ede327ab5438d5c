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

/// Terms of the series: the next is below a thousandth of the first.
const TERMS: u32 = 32;

/// The noise of a reading hidden by the last digit (standard uncertainty `resolution_um` of one reading) where
/// repeats scatter by `scatter_um`, a standard deviation in µm: they are rounded alike; their mean seems too certain.
///
/// Rounding in steps of δ shifts the mean of noise of standard deviation σ; the variance of this over all places is
///
/// ```text
/// v = Σ_k δ²/(2π²k²) exp(-4π²k²σ²/δ²)     v(0) = δ²/12     s² = σ² + δ²/12 - v
/// ```
///
/// (B. Widrow, I. Kollár, Quantization Noise, 2008, ch. 4: characteristic function of the noise at multiples of
/// 2π/δ). The mean of `n` repeats has the variance `v + s²/n`, as if each had `s² + n v`. For σ > δ/2 `v` vanishes.
pub(crate) fn hidden_um(resolution_um: f64, scatter_um: f64, repeats: f64) -> f64 {
    let (rounding, scatter) = (resolution_um.powi(2), scatter_um.powi(2));
    let common = |noise: f64| -> f64 {
        let term = |k: u32| {
            let waves = 2.0 * (PI * f64::from(k)).powi(2);
            12.0 * rounding / waves * (-2.0 * waves * noise / (12.0 * rounding)).exp()
        };
        (1..=TERMS).map(term).sum()
    };
    // σ² between zero and all that is seen.
    let (mut low, mut high) = (0.0, scatter);
    for _ in 0..HALVINGS {
        let noise = 0.5 * (low + high);
        match noise + rounding - common(noise) > scatter {
            true => high = noise,
            false => low = noise,
        }
    }
    let of_each = scatter + repeats * common(high);
    (of_each - scatter.max(rounding)).max(0.0).sqrt()
}

/// They find σ² to a millionth.
const HALVINGS: u32 = 20;

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// The mean of rounded readings at a position anywhere between two digits: its variance over 4000 positions is
    /// the noise that is seen and hidden, over the number of repeats, within four standard errors of such a variance.
    #[test]
    fn means_of_rounded_readings_are_as_uncertain_as_said() {
        let mut generator = ChaCha8Rng::seed_from_u64(12);
        for sigma in [0.0, 0.1, 0.2, 0.3, 0.5] {
            let (places, repeats) = (4000, 5);
            let (mut squares, mut within) = (0.0, 0.0);
            for _ in 0..places {
                let place: f64 = generator.random_range(-0.5..0.5);
                let mut one = || {
                    let sum: f64 = (0..12).map(|_| generator.random::<f64>()).sum();
                    (place + sigma * (sum - 6.0)).round()
                };
                let readings: Vec<f64> = (0..repeats).map(|_| one()).collect();
                let mean = readings.iter().sum::<f64>() / f64::from(repeats);
                squares += (mean - place).powi(2);
                within += readings.iter().map(|r| (r - mean).powi(2)).sum::<f64>();
            }
            let scatter = (within / f64::from(places * (repeats - 1))).sqrt();
            let resolution = 12_f64.sqrt().recip();
            let hidden = hidden_um(resolution, scatter, f64::from(repeats));
            let seen = scatter.max(resolution);
            let said = (seen * seen + hidden * hidden) / f64::from(repeats);
            let ratio = squares / f64::from(places) / said;
            let four = 4.0 * (2.0 / f64::from(places)).sqrt();
            assert!((ratio - 1.0).abs() < four, "{sigma}: {ratio}");
        }
    }
}
