//! Numbers of result files, without meaningless digits.

/// Rounded to decimals; no negative zero.
pub fn round(value: f64, decimals: i32) -> f64 {
    let power = 10_f64.powi(decimals);
    (value * power).round() / power + 0.0
}

/// A point as people read it, to a tenth of a micrometre: `(140.783, 0, 12.5) mm`.
pub fn point_mm(point: [f64; 3]) -> String {
    let [x, y, z] = point.map(|mm| round(mm, 4));
    format!("({x}, {y}, {z}) mm")
}

/// Rounded to three significant digits, for probabilities.
pub fn significant(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Below this the digits of a rounded number are those of the shortest text that reads back as the same number.
const SURE: f64 = 1e15;

/// Appends what `Display` makes of [`round`], in a fifth of the time: for tables of a million rows.
pub fn push_rounded(text: &mut String, value: f64, decimals: u8) {
    let units = (value * 10_f64.powi(i32::from(decimals))).round();
    if units.abs() < SURE && decimals < 16 {
        #[expect(clippy::cast_possible_truncation, reason = "a whole number below 1e15")]
        push_decimal(text, units as i64, decimals);
    } else {
        text.push_str(&round(value, i32::from(decimals)).to_string());
    }
}

/// Appends a whole number of units of the last decimal as a decimal number without trailing zeros.
fn push_decimal(text: &mut String, units: i64, mut decimals: u8) {
    let mut rest = units.unsigned_abs();
    while decimals > 0 && rest.is_multiple_of(10) {
        rest /= 10;
        decimals -= 1;
    }
    let mut digits = [b'0'; 20];
    let mut first = digits.len();
    let mut put = |digit: u8| {
        first -= 1;
        digits[first] = digit;
    };
    let mut place = 0;
    while rest > 0 || place <= decimals {
        if place == decimals && place > 0 {
            put(b'.');
        }
        put(b"0123456789"[(rest % 10) as usize]);
        rest /= 10;
        place += 1;
    }
    if units < 0 {
        put(b'-');
    }
    text.push_str(str::from_utf8(&digits[first..]).unwrap_or_default());
}

/// Decimals with which an uncertainty has two significant digits, six at most; one where it is infinite, for it says
/// nothing then.
///
/// ```
/// use trueaxis_files::decimals;
///
/// assert_eq!([123.0, 1.2, 0.12, 3e-9].map(decimals), [0, 1, 2, 6]);
/// assert_eq!(decimals(f64::INFINITY), 1);
/// ```
pub fn decimals(uncertainty: f64) -> usize {
    if uncertainty.is_infinite() {
        return 1;
    }
    let limits = [9.95, 0.995, 0.0995, 9.95e-3, 9.95e-4, 9.95e-5];
    limits
        .iter()
        .take_while(|limit| uncertainty.abs() < **limit)
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn idle_digits_go() {
        assert_eq!(round(-0.000_000_4, 6).to_bits(), 0.0_f64.to_bits());
        assert_eq!(round(1.000_000_6, 6).to_string(), "1.000001");
        assert_eq!(significant(0.012_345).to_string(), "0.0123");
        let point = [140.783_000_000_000_02, 462.788_066_666_666_7, -1e-9];
        assert_eq!(point_mm(point), "(140.783, 462.7881, 0) mm");
    }

    /// Of all sizes and both signs, and what no table should hold.
    #[test]
    fn rounded_numbers_are_appended_as_they_are_displayed() {
        let special = [0.0, -0.0, 0.00005, -0.00004, f64::NAN, f64::INFINITY, 1e300];
        let sizes = (0..4000_i32).map(|k| f64::from(k).sin() * 10_f64.powi(k % 40 - 20));
        let units = (-2000..2000).map(|k| f64::from(k) / 1e4);
        for value in special.into_iter().chain(sizes).chain(units) {
            for decimals in [0, 1, 4, 9] {
                let mut text = String::new();
                push_rounded(&mut text, value, decimals);
                assert_eq!(
                    text,
                    round(value, i32::from(decimals)).to_string(),
                    "{value:e} {decimals}"
                );
            }
        }
    }
}
