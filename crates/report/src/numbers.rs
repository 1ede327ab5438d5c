//! Numbers as people read them: to the digits that their uncertainty leaves.

use statrs::distribution::{ContinuousCDF, Normal};
use trueaxis_leastsquares::student_two_sided;

/// Coverage factor where many degrees of freedom stand behind u.
pub(crate) const COVERAGE: f64 = 2.0;

/// Half width of the 95 % interval: Student's factor where that is more than [`COVERAGE`]. Without degrees of freedom
/// nothing is known; what is certain has no uncertainty.
pub(crate) fn expanded(u: f64, dof: Option<f64>) -> f64 {
    match u > 0.0 {
        true => u * student_two_sided(0.05, dof.unwrap_or(f64::INFINITY)).max(COVERAGE),
        false => u,
    }
}

/// The value that a standard normal variable stays below with this probability.
pub(crate) fn normal_quantile(probability: f64) -> f64 {
    Normal::standard().inverse_cdf(probability)
}

/// With a real minus sign, and no negative zero.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if value.is_infinite() && value > 0.0 {
        return "∞".to_owned();
    }
    let text = match value.abs() >= 1e9 {
        true => format!("{value:.0e}"),
        false => format!("{value:.decimals$}"),
    };
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    match text.strip_prefix('-') {
        Some(digits) if is_zero => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// The same with a plus for what is positive.
pub(crate) fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    match text.chars().any(|c| matches!(c, '1'..='9')) && value > 0.0 {
        true => format!("+{text}"),
        false => text,
    }
}

/// A value with its expanded uncertainty: `+14.5 ± 1.4`.
pub(crate) fn with_u(value: f64, expanded: f64, decimals: usize) -> String {
    let (value, expanded) = (signed(value, decimals), fixed(expanded, decimals));
    format!("{value} ± {expanded}")
}

/// To three significant digits.
pub(crate) fn rough(value: f64) -> String {
    match value.abs() {
        x if x >= 1e5 => format!("{value:.2e}"),
        x if x >= 99.95 => fixed(value, 0),
        x if x >= 9.995 => fixed(value, 1),
        x if x >= 0.0995 => fixed(value, 2),
        x if x > 0.0 && x < 1e-3 => format!("{value:.1e}"),
        _ => fixed(value, 3),
    }
}

/// A p-value as an equation: `p = 0.042`, `p = 3·10⁻¹²`, `p < 10⁻³⁰⁰`.
pub(crate) fn p_value(p: f64) -> String {
    typeset(&trueaxis_files::p_value(p))
}

/// The same without its name: `0.042`, `3·10⁻¹²`, `below 10⁻³⁰⁰`.
pub(crate) fn probability(p: f64) -> String {
    typeset(&trueaxis_files::probability(p))
}

/// With a power of ten for the exponent; a bound is a power alone.
fn typeset(text: &str) -> String {
    let Some((digits, exponent)) = text.split_once("e-") else {
        return text.to_owned();
    };
    let raised = exponent.chars().filter_map(|c| c.to_digit(10));
    let raised: String = raised.map(|digit| SUPERSCRIPTS[digit as usize]).collect();
    match digits {
        "p < 1" => format!("p < 10⁻{raised}"),
        "below 1" => format!("below 10⁻{raised}"),
        _ => format!("{digits}·10⁻{raised}"),
    }
}

const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

#[cfg(test)]
mod tests {
    use super::*;

    /// `calibration.json` rounds degrees of freedom to tenths: of less than 0.05 it says 0.
    #[test]
    fn without_degrees_of_freedom_nothing_is_known() {
        assert_eq!(fixed(expanded(0.3, Some(0.0)), 1), "∞");
        assert_eq!(fixed(1.23e12, 0), "1e12");
        assert!(expanded(0.3, Some(0.009)) > expanded(0.3, Some(1.0)));
        assert!((expanded(0.3, Some(1.0)) / 0.3 - 12.706).abs() < 1e-3);
        assert!((expanded(0.3, None) - 0.6).abs() < 1e-12);
        assert!(expanded(0.0, Some(0.0)).abs() < f64::MIN_POSITIVE);
    }

    #[test]
    fn numbers_as_people_write_them() {
        assert_eq!(p_value(0.4168), "p = 0.417");
        assert_eq!(p_value(3.4e-12), "p = 3·10⁻¹²");
        assert_eq!(p_value(1e-15), "p = 1·10⁻¹⁵");
        assert_eq!(p_value(0.0), "p < 10⁻³⁰⁰");
        assert_eq!(probability(0.4168), "0.417");
        assert_eq!(probability(0.0), "below 10⁻³⁰⁰");
        assert_eq!(
            [signed(0.0, 1), signed(-0.01, 1), signed(0.26, 1)],
            ["0.0", "0.0", "+0.3"]
        );
    }
}
