//! How many standard uncertainties make an interval.

use trueaxis_leastsquares::student_two_sided;

/// Probability of a truth outside `± coverage_factor · u`.
const OUTSIDE: f64 = 0.05;

/// The factor `k` for which `± k u` holds the truth with 95 %: Student's t for the degrees of
/// freedom of u, 1.96 if these are infinite, infinity without any.
///
/// ```
/// use trueaxis_predict::coverage_factor;
///
/// assert!((coverage_factor(f64::INFINITY) - 1.96).abs() < 1e-4);
/// assert!((coverage_factor(10.0) - 2.228).abs() < 1e-3);
/// ```
pub fn coverage_factor(degrees_of_freedom: f64) -> f64 {
    student_two_sided(OUTSIDE, degrees_of_freedom)
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
        let nearly_normal = [1e4 * (1.0 - 1e-9), 1e4].map(coverage_factor);
        assert!((nearly_normal[0] - nearly_normal[1]).abs() < 1e-6);
        assert!(coverage_factor(0.0).is_infinite());
    }
}
