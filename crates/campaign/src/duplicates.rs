//! Rows that stand in a file twice.

use std::collections::HashMap;
use std::path::Path;

use crate::reading::{Reading, readings_of};
use crate::{Error, Place, Problem, Stop, Target};

/// Refuses a target read twice at one stop, and a stop that is repeated with identical times.
pub(crate) fn check<R: Reading>(
    file: &Path,
    stops: &[Stop],
    readings: &[R],
    targets: &[Target],
) -> Result<(), Error> {
    for stop in stops {
        check_stop(file, readings_of(stop, readings), targets)?;
    }
    // With a clock that runs on from stop to stop no time can come twice: nothing to look up.
    if clock_runs_on(stops, readings) {
        return Ok(());
    }
    check_visits(file, stops, readings)
}

/// A stop has at most one reading for each target, so the search ends soon.
fn check_stop<R: Reading>(file: &Path, readings: &[R], targets: &[Target]) -> Result<(), Error> {
    for (i, second) in readings.iter().enumerate() {
        let first = readings[..i].iter().find(|r| r.target() == second.target());
        if let Some(first) = first {
            return Err(Problem::TargetReadTwice {
                target: targets[second.target()].name.clone(),
                first_line: first.line(),
            }
            .at(Place::line(file, second.line())));
        }
    }
    Ok(())
}

fn clock_runs_on<R: Reading>(stops: &[Stop], readings: &[R]) -> bool {
    let mut latest = f64::NEG_INFINITY;
    stops.iter().all(|stop| {
        let times = || readings_of(stop, readings).iter().map(Reading::time_s);
        let runs_on = times().all(|time_s| time_s > latest);
        latest = times().fold(latest, f64::max);
        runs_on
    })
}

fn check_visits<R: Reading>(file: &Path, stops: &[Stop], readings: &[R]) -> Result<(), Error> {
    let mut first_lines = HashMap::with_capacity(readings.len());
    for stop in stops {
        for reading in readings_of(stop, readings) {
            let time_bits = (reading.time_s() + 0.0).to_bits();
            let sighting = (stop.visit(), reading.target(), time_bits);
            if let Some(first_line) = first_lines.insert(sighting, reading.line()) {
                return Err(Problem::StopRepeated {
                    time_s: reading.time_s(),
                    first_line,
                }
                .at(Place::line(file, reading.line())));
            }
        }
    }
    Ok(())
}
