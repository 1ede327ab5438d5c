//! Smooth courses of unknown form in half waves.

use std::f64::consts::PI;

/// `cos(kπx)` for `k` from 1 to `count`, x from 0 to 1: half waves, so that a trend needs few of them.
///
/// By Chebyshev's recurrence, `cos((k+1)πx) = 2 cos(πx) cos(kπx) - cos((k-1)πx)`.
pub fn half_waves(x: f64, count: u32) -> impl Iterator<Item = f64> {
    let first = (PI * x).cos();
    let next = move |&[before, here]: &[f64; 2]| Some([here, 2.0 * first * here - before]);
    let waves = std::iter::successors(Some([1.0, first]), next);
    waves.map(|[_, here]| here).take(count as usize)
}

/// `S_k^½` for `k` from 0 to `count`: standard deviations of the coefficients of the constant and of each half wave in
/// a process of unit variance with Matérn's covariance (ν = 3/2) of this correlation length, a part of the range
/// (Solin and Särkkä 2020): `S_k ~ (3/ℓ² + k²π²)⁻²`, `S_0 + ½ Σ S_k = 1`.
pub fn matern_roots(length: f64, count: u32) -> Vec<f64> {
    let at = |k: u32| {
        let wave = f64::from(k) * PI;
        (3.0 / (length * length) + wave * wave).powi(-2)
    };
    let spectrum: Vec<f64> = (0..=count).map(at).collect();
    let variance = spectrum[0] + 0.5 * spectrum[1..].iter().sum::<f64>();
    spectrum.iter().map(|s| (s / variance).sqrt()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_waves_are_cosines() {
        for x in [0.0, 0.3, 0.77, 1.0] {
            for (k, wave) in (1..).zip(half_waves(x, 24)) {
                assert!((wave - (f64::from(k) * PI * x).cos()).abs() < 1e-12);
            }
        }
    }
}
