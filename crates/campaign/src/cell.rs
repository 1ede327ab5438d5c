//! One cell of a CSV file: a number, or the reason why it is none.

/// No number of a table is as large, in mm, µm, s or degrees; its square is a number, too.
const TOO_LARGE: f64 = 1e15;

/// A number that can be.
pub(crate) fn number(cell: &[u8]) -> Option<f64> {
    let number: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
    (number.abs() < TOO_LARGE).then_some(number)
}

/// What was found and what is expected, for a cell that [`number`] refuses.
pub(crate) fn number_problem(cell: &[u8]) -> (String, String) {
    let text = String::from_utf8_lossy(cell);
    let point = text.replace(',', ".");
    let ascii_minus = text.replace('\u{2212}', "-");
    let finite = |text: &str| number(text.as_bytes()).is_some();
    let nothing = "a number; remove the row if nothing was measured".to_owned();
    if text.is_empty() {
        return ("the cell is empty".to_owned(), nothing);
    }
    if let Ok(number) = text.parse::<f64>() {
        let what = if number.is_finite() {
            "is too large"
        } else {
            "is not a finite number"
        };
        return (format!("\"{text}\" {what}"), nothing);
    }
    let expected = if finite(&point) {
        format!("a decimal point, such as {point}")
    } else if finite(&ascii_minus) {
        format!("the minus sign of the keyboard, as in {ascii_minus}")
    } else {
        "a number with a decimal point and without unit, such as 12.5".to_owned()
    };
    (format!("\"{text}\" is not a number"), expected)
}

/// The same for a cell that should hold seconds: clocks and calendars have words of their own.
pub(crate) fn time_problem(cell: &[u8]) -> (String, String) {
    let text = String::from_utf8_lossy(cell);
    if text.is_empty() {
        let expected =
            "seconds since the start of the campaign; where nobody logged them, number the rows";
        return ("the cell is empty".to_owned(), expected.to_owned());
    }
    if let Some(seconds) = seconds_of_clock(&text) {
        (
            format!("\"{text}\" is a time of day"),
            format!(
                "seconds since the start of the campaign: as hours, minutes and seconds it is {seconds}"
            ),
        )
    } else if is_date(&text) {
        (
            format!("\"{text}\" is a date"),
            "seconds since the start of the campaign: subtract the date and time of the first row"
                .to_owned(),
        )
    } else {
        number_problem(cell)
    }
}

/// `hh:mm` or `hh:mm:ss`, in seconds.
fn seconds_of_clock(text: &str) -> Option<f64> {
    let parts: Vec<f64> = text
        .split(':')
        .map(|part| number(part.replace(',', ".").as_bytes()))
        .collect::<Option<_>>()?;
    match *parts.as_slice() {
        [hours, minutes] => Some(3600.0 * hours + 60.0 * minutes),
        [hours, minutes, seconds] => Some(3600.0 * hours + 60.0 * minutes + seconds),
        _ => None,
    }
}

/// Whether the text begins like a day of the calendar, as 2026-03-31, 31.3.2026 or 3/31/26.
fn is_date(text: &str) -> bool {
    let day = text.split([' ', 'T']).next().unwrap_or_default();
    ['-', '.', '/'].into_iter().any(|separator| {
        let parts: Vec<&str> = day.split(separator).collect();
        let is_number =
            |part: &&str| matches!(part.len(), 1 | 2 | 4) && part.parse::<u32>().is_ok();
        parts.len() == 3 && parts.iter().all(is_number)
    })
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
        for cell in [
            "", "12,5", "NaN", "inf", "1e999", "-1e15", "12.5 mm", "0x10",
        ] {
            assert_eq!(number(cell.as_bytes()), None, "{cell}");
        }
    }

    #[test]
    fn problems_say_how_to_correct_them() {
        let expected = |cell: &str| number_problem(cell.as_bytes()).1;
        assert_eq!(expected("12,5"), "a decimal point, such as 12.5");
        assert_eq!(
            expected("\u{2212}3"),
            "the minus sign of the keyboard, as in -3"
        );
        assert!(expected("").contains("remove the row"));
        assert!(expected("NaN").contains("remove the row"));
    }

    #[test]
    fn clocks_and_calendars_are_no_seconds() {
        for (cell, says) in [
            ("10:15:30.5", "it is 36930.5"),
            ("0:01", "it is 60"),
            ("2026-03-31T10:15:30", "subtract the date"),
            ("31.3.2026 10:15", "subtract the date"),
            ("3/31/26", "subtract the date"),
            ("12.5 s", "without unit"),
            ("", "number the rows"),
            ("12,5", "as 12.5"),
            ("1:2:3:4", "without unit"),
            ("1.234.567", "without unit"),
        ] {
            let expected = time_problem(cell.as_bytes()).1;
            assert!(expected.contains(says), "{cell}: {expected}");
        }
    }

    #[test]
    fn counting_starts_at_one() {
        assert_eq!(counting_number(b"3"), Some(3));
        for cell in ["0", "-1", "1.0", "", "one", "5000000000"] {
            assert_eq!(counting_number(cell.as_bytes()), None, "{cell}");
        }
    }
}
