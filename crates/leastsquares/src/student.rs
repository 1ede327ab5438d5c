//! Student's t distribution, for tests with an estimated variance.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// The value that |t| with `degrees_of_freedom` exceeds with `probability`; that of the normal
/// distribution for infinitely many, infinity where the question has no meaning.
pub fn student_two_sided(probability: f64, degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom.is_infinite() {
        return crate::chi_squared_quantile(1.0 - probability, 1.0).sqrt();
    }
    match StudentsT::new(0.0, 1.0, degrees_of_freedom) {
        Ok(distribution) if (0.0..1.0).contains(&probability) && probability > 0.0 => {
            -distribution.inverse_cdf(0.5 * probability)
        }
        _ => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, Table 26.10; the tail of 1e-6 with two degrees of freedom in closed
    /// form, `t = (1 - p) √(2 / (1 - (1 - p)²))`.
    #[test]
    fn agrees_with_tables_and_closed_form() {
        for (probability, degrees, value) in [
            (0.05, 8.0, 2.306_004),
            (0.01, 3.0, 5.840_909),
            (0.001, 30.0, 3.645_959),
            (0.05, f64::INFINITY, 1.959_964),
        ] {
            assert!((student_two_sided(probability, degrees) / value - 1.0_f64).abs() < 1e-6);
        }
        let inside: f64 = 1.0 - 1e-6;
        let exact = inside * (2.0 / (1.0 - inside * inside)).sqrt();
        assert!((student_two_sided(1e-6, 2.0) / exact - 1.0).abs() < 1e-6);
    }
}
