//! Messages about what is unusual in a campaign but not an error.

use crate::reading::Reading;
use crate::{Campaign, Stop, Target};

/// The first row that is earlier than the row before it, if there is one. `rows` gives the time and the line of each row.
pub(crate) fn clock_going_back(
    file_name: &str,
    rows: impl IntoIterator<Item = (f64, usize)>,
) -> Option<String> {
    let mut before: Option<f64> = None;
    for (time_s, line) in rows {
        if let Some(before_s) = before.filter(|&before_s| time_s < before_s) {
            return Some(format!(
                "{file_name} line {line}, column time_s: the time goes back from {before_s} s to \
                 {time_s} s; drifts cannot be told from a clock that was reset"
            ));
        }
        before = Some(time_s);
    }
    None
}

/// A file that was cut off within its last number is a table like others.
pub(crate) fn without_line_end(file_name: &str, text: &str) -> Option<String> {
    let notice = || {
        format!(
            "{file_name}: the last line has no end; was the file saved completely? Look at its last number"
        )
    };
    let has_end = text.trim_end_matches([' ', '\t']).ends_with('\n');
    (!has_end).then(notice)
}

/// Reflectors whose names differ only in case, blanks and punctuation: perhaps one, written in two ways.
pub(crate) fn similar_reflectors(targets: &[Target]) -> Vec<String> {
    let letters = |name: &str| -> String {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    };
    let mut declared: Vec<&str> = Vec::new();
    let mut notices = Vec::new();
    for name in targets.iter().filter_map(|t| t.reflector.as_deref()) {
        if declared.contains(&name) {
            continue;
        }
        let similar = |other: &&&str| letters(other) == letters(name);
        if let Some(other) = declared.iter().find(similar) {
            notices.push(format!(
                "reflectors `{other}` and `{name}` of campaign.json count as two; if they are one, write \
                 the name alike"
            ));
        }
        declared.push(name);
    }
    notices
}

/// Stations, runs and targets of which the file has no row.
pub(crate) fn without_rows<R: Reading>(
    file_name: &str,
    campaign: &Campaign,
    stops: &[Stop],
    readings: &[R],
) -> Vec<String> {
    let stations = match R::HAS_STATION {
        true => unseen(
            campaign.stations.iter().map(|s| s.name.as_str()),
            stops.iter().map(|stop| stop.station),
        ),
        // A points campaign may list stations, but has no column for them.
        false => Vec::new(),
    };
    let runs = unseen(
        campaign.runs.iter().map(|r| r.name.as_str()),
        stops
            .iter()
            .filter_map(|stop| campaign.steps[stop.step].run),
    );
    let targets = unseen(
        campaign.targets.iter().map(|t| t.name.as_str()),
        readings.iter().map(Reading::target),
    );
    [("station", stations), ("run", runs), ("target", targets)]
        .into_iter()
        .flat_map(|(what, names)| names.into_iter().map(move |name| (what, name)))
        .map(|(what, name)| format!("{file_name}: {what} `{name}` of campaign.json has no row"))
        .collect()
}

/// The names whose index is not among `seen`.
fn unseen<'a>(
    names: impl Iterator<Item = &'a str>,
    seen: impl Iterator<Item = usize>,
) -> Vec<&'a str> {
    let mut names: Vec<Option<&str>> = names.map(Some).collect();
    seen.for_each(|index| names[index] = None);
    names.into_iter().flatten().collect()
}
