//! Student's t distribution, for tests with an estimated variance.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use statrs::function::gamma::ln_gamma;

/// Degrees of freedom from which the first term of the expansion about the normal quantile (Abramowitz and Stegun 26.7.5)
/// gives that of 95 % to 1e-7; the inverse of the incomplete beta function loses digits there.
const NEARLY_NORMAL: f64 = 1e4;

/// `ν / (ν + t²)` below which the first term of the incomplete beta function is all of it, to 1e-8; its inverse fails
/// there.
const FAR_OUT: f64 = 1e-8;

/// The value that |t| with `degrees_of_freedom` exceeds with `probability`; that of the normal
/// distribution for infinitely many, infinity where the question has no meaning or nothing is known, as without degrees
/// of freedom.
///
/// ```text
/// P(|t| > T) = I_x(a, ½)     x = ν / (ν + T²)     a = ν / 2     I_x(a, ½) = xᵃ / (a B(a, ½)) (1 + O(x))
/// ```
pub fn student_two_sided(probability: f64, degrees_of_freedom: f64) -> f64 {
    if !(probability > 0.0 && probability < 1.0) {
        return f64::INFINITY;
    }
    if degrees_of_freedom >= NEARLY_NORMAL {
        let z = -Normal::standard().inverse_cdf(0.5 * probability);
        return z + (z.powi(3) + z) / (4.0 * degrees_of_freedom);
    }
    let Ok(distribution) = StudentsT::new(0.0, 1.0, degrees_of_freedom) else {
        return f64::INFINITY;
    };
    let a = 0.5 * degrees_of_freedom;
    let ln_a_beta = ln_gamma(a + 1.0) + ln_gamma(0.5) - ln_gamma(a + 0.5);
    let x = ((probability.ln() + ln_a_beta) / a).exp();
    match x < FAR_OUT {
        true => (degrees_of_freedom / x).sqrt(),
        false => -distribution.inverse_cdf(0.5 * probability),
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

    /// With one degree of freedom `t = cot(πp/2)`, on both sides of where the first term is all.
    #[test]
    fn agrees_far_out_with_cauchy() {
        for exponent in 1..30 {
            let probability = 10_f64.powf(-0.5 * f64::from(exponent));
            let exact = (0.5 * std::f64::consts::PI * probability).tan().recip();
            let ratio = student_two_sided(probability, 1.0) / exact;
            assert!((ratio - 1.0).abs() < 1e-6, "{probability:e}: {ratio}");
        }
    }

    /// With ever fewer degrees of freedom less is known, in the end nothing.
    #[test]
    fn the_factor_grows_to_infinity() {
        let mut before = student_two_sided(0.05, f64::INFINITY);
        let degrees = (-60..=60).rev().map(|k| 10_f64.powf(0.1 * f64::from(k)));
        for degrees in degrees.chain([0.0]) {
            let factor = student_two_sided(0.05, degrees);
            assert!(factor >= before, "{degrees}: {factor} after {before}");
            before = factor;
        }
        assert!(before.is_infinite());
    }
}
