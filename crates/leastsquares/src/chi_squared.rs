//! The chi-squared distribution and that of ratios of two, for tests of residuals.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

/// Probability that a chi-squared variable with `degrees_of_freedom` exceeds `value`; 1 where the
/// question has no meaning (no degrees of freedom, no number).
pub fn chi_squared_upper_tail(value: f64, degrees_of_freedom: f64) -> f64 {
    if value.is_nan() {
        return 1.0;
    }
    ChiSquared::new(degrees_of_freedom).map_or(1.0, |d| d.sf(value.max(0.0)))
}

/// Probability that the ratio of two mean squares of noise, with `above` and `below` degrees of freedom, exceeds
/// `value` (Fisher's F); 1 where the question has no meaning.
pub fn f_upper_tail(value: f64, above: f64, below: f64) -> f64 {
    if value.is_nan() {
        return 1.0;
    }
    FisherSnedecor::new(above, below).map_or(1.0, |d| d.sf(value.max(0.0)))
}

/// The value that a chi-squared variable with `degrees_of_freedom` stays below with `probability`;
/// infinity where the question has no meaning.
pub fn chi_squared_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    match ChiSquared::new(degrees_of_freedom) {
        Ok(distribution) if (0.0..1.0).contains(&probability) => {
            distribution.inverse_cdf(probability)
        }
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, Table 26.8.
    #[test]
    fn agrees_with_the_printed_table() {
        for (probability, degrees, value) in [
            (0.95, 1.0, 3.84146),
            (0.99, 3.0, 11.3449),
            (0.999, 100.0, 149.449),
        ] {
            assert!((chi_squared_quantile(probability, degrees) / value - 1.0).abs() < 1e-5);
            assert!((chi_squared_upper_tail(value, degrees) - (1.0 - probability)).abs() < 1e-6);
        }
        // Table 26.9.
        for (probability, above, below, value) in [(0.05, 3.0, 6.0, 4.76), (0.01, 3.0, 24.0, 4.72)]
        {
            assert!((f_upper_tail(value, above, below) / probability - 1.0).abs() < 0.01);
        }
    }
}
