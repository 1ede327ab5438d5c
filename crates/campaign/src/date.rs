//! The day of a measurement.

use trueaxis_files::{DocumentError, DocumentProblem};

/// Refuses what is not a day of the calendar as ISO 8601 writes it, `YYYY-MM-DD`.
pub(crate) fn check(date: Option<&str>) -> Result<(), DocumentError> {
    match date {
        Some(date) if !is_day(date) => {
            let found = format!("found \"{date}\"");
            let problem =
                DocumentProblem::value(found, "a day as year-month-day, such as 2026-03-31");
            Err(problem.in_field("date"))
        }
        _ => Ok(()),
    }
}

fn is_day(date: &str) -> bool {
    let parts: Vec<&str> = date.split('-').collect();
    let &[year, month, day] = parts.as_slice() else {
        return false;
    };
    let number = |text: &str, digits: usize| -> Option<u32> {
        let is_number = text.len() == digits && text.bytes().all(|b| b.is_ascii_digit());
        is_number.then(|| text.parse().ok()).flatten()
    };
    let (Some(year), Some(month), Some(day)) = (number(year, 4), number(month, 2), number(day, 2))
    else {
        return false;
    };
    let is_leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 => 28 + u32::from(is_leap),
        _ => 0,
    };
    (1..=days).contains(&day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_days_of_the_calendar() {
        for date in ["2026-11-23", "2024-02-29", "2000-02-29"] {
            assert!(is_day(date), "{date}");
        }
        for date in [
            "23.11.2026",
            "2026-11-31",
            "2023-02-29",
            "1900-02-29",
            "2026-13-01",
            "2026-1-2",
            "2026-11-00",
            "26-11-23",
            "2026-11-23T08:00",
            "+026-11-23",
            "",
        ] {
            assert!(!is_day(date), "{date}");
        }
    }
}
