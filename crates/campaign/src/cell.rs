//! One cell of a CSV file: numbers, and in words why it is none.

/// A finite number.
pub(crate) fn number(cell: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
    number.is_finite().then_some(number)
}

/// What was found and what is expected, for a cell that [`number`] refuses.
pub(crate) fn number_problem(cell: &[u8]) -> (String, String) {
    let text = String::from_utf8_lossy(cell);
    let point = text.replace(',', ".");
    let ascii_minus = text.replace('\u{2212}', "-");
    let finite = |text: &str| number(text.as_bytes()).is_some();
    if text.is_empty() {
        (
            "the cell is empty".to_owned(),
            "a number; remove the row if nothing was measured".to_owned(),
        )
    } else if text.parse::<f64>().is_ok() {
        (
            format!("\"{text}\" is not a finite number"),
            "a number; remove the row if nothing was measured".to_owned(),
        )
    } else if finite(&point) {
        (
            format!("\"{text}\" is not a number"),
            format!("a decimal point, as {point}"),
        )
    } else if finite(&ascii_minus) {
        (
            format!("\"{text}\" is not a number"),
            format!("the minus sign of the keyboard, as {ascii_minus}"),
        )
    } else {
        (
            format!("\"{text}\" is not a number"),
            "a number with a decimal point and without unit, as 12.5".to_owned(),
        )
    }
}

/// A whole number from 1.
pub(crate) fn counting_number(cell: &[u8]) -> Option<u32> {
    let number = std::str::from_utf8(cell).ok()?.parse().ok()?;
    (number > 0).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_numbers_are_numbers() {
        assert_eq!(number(b"-12.5e-1"), Some(-1.25));
        for cell in ["", "12,5", "NaN", "inf", "1e999", "12.5 mm", "0x10"] {
            assert_eq!(number(cell.as_bytes()), None, "{cell}");
        }
    }

    #[test]
    fn problems_say_how_to_mend() {
        let expected = |cell: &str| number_problem(cell.as_bytes()).1;
        assert_eq!(expected("12,5"), "a decimal point, as 12.5");
        assert_eq!(
            expected("\u{2212}3"),
            "the minus sign of the keyboard, as -3"
        );
        assert!(expected("").contains("remove the row"));
        assert!(expected("NaN").contains("remove the row"));
    }

    #[test]
    fn counting_starts_at_one() {
        assert_eq!(counting_number(b"3"), Some(3));
        for cell in ["0", "-1", "1.0", "", "one", "5000000000"] {
            assert_eq!(counting_number(cell.as_bytes()), None, "{cell}");
        }
    }
}
