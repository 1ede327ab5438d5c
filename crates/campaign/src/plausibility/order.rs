//! Rows that are not in measuring order, and times that are not seconds.
//!
//! A stop is a group of consecutive rows, and a station's occupation a group of consecutive stops. A table that was sorted by
//! point, target or station has the rows of these groups apart, and its times jump to and fro. What sorting by time would
//! make of it distinguishes it from a clock that was set back, which is only a notice: a sorted table then has fewer
//! stops, or as many in fewer occupations; with a reset clock the rows of different stations or runs would be mixed.

use std::collections::HashMap;
use std::path::Path;

use crate::reading::{Reading, readings_of};
use crate::{Error, Place, Problem, Stop, notices};

/// A mean time between readings below this, s, is a time in days or hours: no tracker is carried, no
/// machine moved in hundredths of a second.
const LEAST_SPACING_S: f64 = 0.01;

/// Fewer readings may be in a test of the instrument.
const LEAST_READINGS: usize = 10;

/// Refuses rows that are not in measuring order; returns notices about the clock.
pub(crate) fn check<R: Reading>(
    file: &Path,
    name: &str,
    stops: &[Stop],
    readings: &[R],
) -> Result<Vec<String>, Error> {
    let rows = || readings.iter().map(|r| (r.time_s(), r.line()));
    let goes_back = notices::clock_going_back(name, rows());
    if goes_back.is_some() {
        check_order(file, stops, readings)?;
    }
    let others = [too_fast(name, readings), one_by_one(name, stops, readings)];
    Ok(others.into_iter().chain([goes_back]).flatten().collect())
}

/// So often a clock is set back in a campaign, by a restart or at midnight; tables that were sorted go back more often.
const MOST_RESETS: usize = 5;

fn check_order<R: Reading>(file: &Path, stops: &[Stop], readings: &[R]) -> Result<(), Error> {
    let mut rows: Vec<(f64, &Stop)> = Vec::with_capacity(readings.len());
    for stop in stops {
        let times = readings_of(stop, readings).iter().map(Reading::time_s);
        rows.extend(times.map(|time_s| (time_s, stop)));
    }
    let given = Groups::of(&rows);
    let pairs = rows
        .iter()
        .zip(rows.iter().skip(1))
        .zip(readings.iter().skip(1));
    let mut back = pairs.filter(|((before, now), _)| now.0 < before.0);
    let Some(((&(before_s, _), &(time_s, _)), reading)) = back.next() else {
        return Ok(());
    };
    let times = 1 + back.count();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let by_time = Groups::of(&rows);
    // A clock that was set back once or twice may join occupations of a station, never single stops.
    let is_sorted = by_time.stops < given.stops || times > MOST_RESETS;
    if by_time < given && is_sorted {
        return Err(Problem::NotInMeasuringOrder {
            times,
            before_s,
            time_s,
            stops: given.stops,
            occupations: given.occupations,
            stops_by_time: by_time.stops,
            occupations_by_time: by_time.occupations,
        }
        .at(Place::column(file, reading.line(), "time_s")));
    }
    Ok(())
}

/// How many groups of consecutive rows there are.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Groups {
    /// Of one visit of the machine.
    stops: usize,
    /// Of one station.
    occupations: usize,
}

impl Groups {
    fn of(rows: &[(f64, &Stop)]) -> Self {
        Self {
            stops: rows.chunk_by(|a, b| a.1.visit() == b.1.visit()).count(),
            occupations: rows.chunk_by(|a, b| a.1.station == b.1.station).count(),
        }
    }
}

/// A notice if most stops have one target, though others are read alone at the same position, and no clock says that it was so.
fn one_by_one<R: Reading>(name: &str, stops: &[Stop], readings: &[R]) -> Option<String> {
    let later_s = |two: &[R]| two[1].time_s() - two[0].time_s();
    let both_s = |three: &[R]| [later_s(&three[..2]), later_s(&three[1..])];
    let is_timed = |[a, b]: [f64; 2]| a.total_cmp(&b).is_ne();
    if readings.windows(3).map(both_s).any(is_timed) {
        return None;
    }
    let mut alone: HashMap<_, Vec<_>> = HashMap::new();
    for stop in stops {
        if let [reading] = readings_of(stop, readings) {
            let place = alone.entry((stop.station, stop.step)).or_default();
            place.push(reading.target());
        }
    }
    let several = alone
        .values()
        .filter(|own| own.iter().any(|target| *target != own[0]));
    let count: usize = several.map(Vec::len).sum();
    (2 * count > stops.len()).then(|| {
        format!(
            "{name}: most stops have one target, though several are read at one position; if the machine stood still between them, \
             the rows were sorted: put them into measuring order, or the noise comes out wrong"
        )
    })
}

/// A notice if the readings follow each other faster than any machine.
fn too_fast<R: Reading>(name: &str, readings: &[R]) -> Option<String> {
    let times = || readings.iter().map(Reading::time_s);
    let span_s = times().fold(f64::NEG_INFINITY, f64::max) - times().fold(f64::INFINITY, f64::min);
    let count = readings.len();
    // Exact: far below 2^53 rows. Times that are all alike say nothing.
    let is_too_fast = span_s > 0.0 && span_s < LEAST_SPACING_S * count as f64;
    (is_too_fast && count >= LEAST_READINGS).then(|| {
        format!(
            "{name}, column time_s: {count} readings within {span_s:.3} s; the times look like days or \
             hours, expected seconds: multiply them by 86400 or 3600"
        )
    })
}
