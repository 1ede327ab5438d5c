//! Whether more readings are beyond U than chance explains.
//!
//! The readings of a line share the errors of the calibration: if one is off by more than U, its neighbours are, too. The
//! number above 1 is therefore compared with that of draws from what is declared and known,
//!
//! ```text
//! d ~ N(0, M (C_p + diag u_r²) M)     E_n = d / √(U_r² + U_p²)     p = P(number above 1 ≥ that of the readings)
//! ```

use nalgebra::DMatrix;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_predict::pivoted_cholesky;

/// Draws: a probability of 1 % is known to 0.16 %.
const DRAWS: usize = 4000;

/// Parts of the largest variance that only rounding makes.
const ROUNDING: f64 = 1e-12;

/// The probability that at least `above` of differences with this covariance exceed `limits`; 1 if none does.
pub(crate) fn chance(above: usize, covariance: &DMatrix<f64>, limits: &[f64]) -> f64 {
    if above == 0 {
        return 1.0;
    }
    let (n, least) = (covariance.nrows(), ROUNDING * covariance.diagonal().max());
    let columns = pivoted_cholesky(covariance, least);
    let factor = DMatrix::from_fn(n, columns.len(), |row, column| columns[column][row]);
    // Another seed would change the probability by its uncertainty.
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let normal = DMatrix::from_fn(factor.ncols(), DRAWS, |_, _| -> f64 {
        StandardNormal.sample(&mut rng)
    });
    let draws = factor * normal;
    let as_many = draws.column_iter().filter(|draw| {
        let beyond = draw
            .iter()
            .zip(limits)
            .filter(|(d, limit)| d.abs() > **limit);
        beyond.count() >= above
    });
    // The reading itself is one more draw (Davison and Hinkley 1997, 4.2).
    (as_many.count() + 1) as f64 / (DRAWS + 1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Independent readings: binomial, by hand 0.27 % for five of 21 and 1.4 % for four. One error that all share: all are above 1 with
    /// 4.55 %. The probabilities are known to three standard deviations of 4,000 draws.
    #[test]
    fn a_misfit_is_more_than_chance() {
        let limits = [2.0; 21];
        let independent = |above| chance(above, &DMatrix::identity(21, 21), &limits);
        let shared = |above| chance(above, &DMatrix::from_element(21, 21, 1.0), &limits);
        for (found, expected) in [
            (independent(5), 0.0027),
            (independent(4), 0.014),
            (independent(1), 1.0 - 0.9545_f64.powi(21)),
            (shared(1), 0.0455),
            (shared(21), 0.0455),
        ] {
            let sigma = (expected * (1.0 - expected) / DRAWS as f64).sqrt();
            assert!((found - expected).abs() < 3.0 * sigma, "{found} {expected}");
        }
        // No fewer than the reading itself.
        assert!(independent(0) > 0.99 && independent(21) < 1.5 / DRAWS as f64);
    }
}
