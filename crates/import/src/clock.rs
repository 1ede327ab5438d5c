//! Times of day.

/// A day, s.
pub(crate) const DAY_S: f64 = 86_400.0;

/// Seconds since midnight of the last `h:m:s` in the text, as `2026-03-31 02:21:33.5 PM`; a comma may stand for the
/// point.
pub(crate) fn seconds_of_day(text: &str) -> Option<f64> {
    let upper = text.trim().to_uppercase();
    let (time, afternoon) = match (upper.strip_suffix("PM"), upper.strip_suffix("AM")) {
        (Some(time), _) => (time, Some(true)),
        (_, Some(time)) => (time, Some(false)),
        _ => (upper.as_str(), None),
    };
    let time = time.trim_end().rsplit([' ', 'T']).next()?;
    let time = time.trim_end_matches('Z').replace(',', ".");
    let mut parts = time.split(':');
    let mut hours: f64 = parts.next()?.parse::<u8>().ok()?.into();
    let minutes: f64 = parts.next()?.parse::<u8>().ok()?.into();
    let seconds: f64 = parts.next()?.parse().ok()?;
    if let Some(afternoon) = afternoon {
        hours = hours % 12.0 + if afternoon { 12.0 } else { 0.0 };
    }
    let is_time = hours < 24.0 && minutes < 60.0 && (0.0..61.0).contains(&seconds);
    (is_time && parts.next().is_none()).then_some(hours * 3600.0 + minutes * 60.0 + seconds)
}

/// Times of day into s since the first of them; one that goes back by more than half a day has passed midnight.
#[derive(Debug, Default)]
pub(crate) struct Clock {
    first_s: Option<f64>,
    last_s: f64,
    days_s: f64,
}

impl Clock {
    pub(crate) fn since_first_s(&mut self, of_day_s: f64) -> f64 {
        let first_s = *self.first_s.get_or_insert(of_day_s);
        if of_day_s < self.last_s - DAY_S / 2.0 {
            self.days_s += DAY_S;
        }
        self.last_s = of_day_s;
        trueaxis_files::round(self.days_s + of_day_s - first_s, 3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_day() {
        for (text, expected) in [
            ("10:21:33", Some(37_293.0)),
            ("2026-03-31T10:21:33.5Z", Some(37_293.5)),
            ("31.03.2026 10:21:33,5", Some(37_293.5)),
            ("3/31/2026 12:00:01 AM", Some(1.0)),
            ("3/31/2026 12:00:01 pm", Some(43_201.0)),
            ("25:00:00", None),
            ("10:21", None),
            ("37293", None),
        ] {
            assert_eq!(seconds_of_day(text), expected, "{text}");
        }
    }

    #[test]
    fn midnight_passes() {
        let mut clock = Clock::default();
        let times = [86_000.0, 86_399.5, 0.5, 100.0].map(|s| clock.since_first_s(s).to_string());
        assert_eq!(times, ["0", "399.5", "400.5", "500"]);
    }
}
