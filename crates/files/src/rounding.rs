//! Numbers of result files, without meaningless digits.

/// Rounded to decimals; no negative zero.
pub fn round(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale + 0.0
}

/// Rounded to three significant digits, for probabilities.
pub fn significant(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idle_digits_go() {
        assert_eq!(round(-0.000_000_4, 6).to_bits(), 0.0_f64.to_bits());
        assert_eq!(round(1.000_000_6, 6).to_string(), "1.000001");
        assert_eq!(significant(0.012_345).to_string(), "0.0123");
    }
}
