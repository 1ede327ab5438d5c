//! How many standard uncertainties make an interval.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Share of an interval of `± coverage_factor · u` that holds the truth.
const COVERAGE: f64 = 0.95;

/// The quantile of the normal distribution for it.
const NORMAL_FACTOR: f64 = 1.959_963_984_540_054;

/// Degrees of freedom from which the first term of the expansion about the normal quantile
/// (Abramowitz and Stegun 26.7.5) gives Student's to 1e-7; the inverse of the incomplete beta
/// function loses digits there.
const NEARLY_NORMAL: f64 = 1e4;

/// The factor `k` for which `± k u` holds the truth with 95 %: Student's t for the degrees of
/// freedom of u, 1.96 if these are infinite.
///
/// ```
/// use trueaxis_predict::coverage_factor;
///
/// assert!((coverage_factor(f64::INFINITY) - 1.96).abs() < 1e-4);
/// assert!((coverage_factor(10.0) - 2.228).abs() < 1e-3);
/// ```
pub fn coverage_factor(degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom >= NEARLY_NORMAL {
        let z = NORMAL_FACTOR;
        return z + (z.powi(3) + z) / (4.0 * degrees_of_freedom);
    }
    // Nothing is known without degrees of freedom.
    StudentsT::new(0.0, 1.0, degrees_of_freedom)
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * COVERAGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, Table 26.10.
    #[test]
    fn coverage_agrees_with_the_printed_table() {
        for (degrees, factor) in [(1.0, 12.706), (5.0, 2.571), (30.0, 2.042), (120.0, 1.980)] {
            assert!(
                (coverage_factor(degrees) - factor).abs() < 6e-4,
                "{degrees}"
            );
        }
        let below = coverage_factor(NEARLY_NORMAL * (1.0 - 1e-9));
        assert!((below - coverage_factor(NEARLY_NORMAL)).abs() < 1e-6);
        assert!(coverage_factor(0.0).is_infinite());
    }
}
