//! Significant digits of a standard uncertainty (JCGM 101, 7.9.2).

use crate::error::Error;

/// An f64 carries 15 decimal digits.
const MOST_DIGITS: u32 = 15;

/// Whether a standard uncertainty can be stated to this number of digits.
pub(crate) fn check_digits(significant_digits: u32) -> Result<(), Error> {
    if (1..=MOST_DIGITS).contains(&significant_digits) {
        Ok(())
    } else {
        Err(Error::SignificantDigits {
            significant_digits,
            most: MOST_DIGITS,
        })
    }
}

/// The numerical tolerance δ of a standard uncertainty that is stated to `significant_digits`
/// decimal digits: written as `c × 10^l` with an integer `c` of that number of digits, δ = 10^l / 2.
///
/// An uncertainty of 0 (an output that does not vary) has the tolerance 0. Less than one digit
/// counts as one, more than 15 as 15.
pub(crate) fn numerical_tolerance(u: f64, significant_digits: u32) -> f64 {
    if !u.is_finite() || u.abs() < f64::MIN_POSITIVE {
        return 0.0;
    }
    let decimals = significant_digits.clamp(1, MOST_DIGITS) - 1;
    // Decimal formatting rounds `c` correctly, also where that adds a digit (0.996 to 1.0).
    let rounded = format!("{u:.*e}", decimals as usize);
    let exponent = rounded.split_once('e').and_then(|(_, e)| e.parse().ok());
    let l = exponent.map(|e: i32| e - decimals.cast_signed());
    // 10^l / 2 = 5 × 10^(l - 1), read as a decimal so that it is the nearest f64.
    l.and_then(|l| format!("5e{}", l - 1).parse().ok())
        .unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of JCGM 101, 7.9.2, and of its clause 9; then the edges.
    #[test]
    #[expect(clippy::float_cmp, reason = "the nearest f64 is promised")]
    fn half_of_the_last_significant_digit() {
        for (u, digits, tolerance) in [
            (0.00035, 2, 0.000005),
            (2.0, 1, 0.5),
            (2.0, 2, 0.05),
            (10.1, 2, 0.5),
            (0.0754, 1, 0.005),
            (0.0754, 2, 0.0005),
            (0.0996, 2, 0.005),
            (0.0994, 2, 0.0005),
            (9.99e8, 1, 5e8),
            (1e-5, 1, 5e-6),
            (1000.0, 3, 5.0),
            (0.0, 2, 0.0),
            (f64::NAN, 2, 0.0),
        ] {
            assert_eq!(numerical_tolerance(u, digits), tolerance, "{u} to {digits}");
        }
    }

    #[test]
    fn digits_beyond_an_f64_are_refused() {
        assert!(check_digits(1).is_ok() && check_digits(15).is_ok());
        for significant_digits in [0, 16] {
            let refused = check_digits(significant_digits).unwrap_err();
            assert!(matches!(refused, Error::SignificantDigits { most: 15, .. }));
        }
    }
}
