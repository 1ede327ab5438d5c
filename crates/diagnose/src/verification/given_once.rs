//! Readings that are given more than once, in two files or within one: as a second measurement they would make everything
//! look more certain than it is. Tables that read again what an earlier one did are named, too: without a calibration each
//! has a mean curve of its own, and differences between them are visible only as cycles of one table.

use std::collections::HashMap;

use trueaxis_campaign::{Verification, VerificationReading};

use crate::numbers::extremes;
use crate::verification::arrivals::{are_same, are_timed, is_same};

/// Consecutive readings from which on two tables, or two parts of one, are the same; fewer may agree by chance.
const LEAST_REPEATED: usize = 6;

/// The verifications without those that repeat an earlier one reading by reading.
pub(crate) fn given_once<'v>(
    all: &'v [Verification],
    notices: &mut Vec<String>,
) -> Vec<&'v Verification> {
    let mut once: Vec<&Verification> = Vec::new();
    for verification in all {
        let is_repeated = |other: &&&Verification| {
            let mut rows = other.readings.iter().zip(&verification.readings);
            let count = verification.readings.len();
            count >= LEAST_REPEATED
                && other.readings.len() == count
                // A machine may show the same again to its last digit; a clock distinguishes them.
                && (are_timed(&other.readings) || !is_coarse(&other.readings, 0.0))
                && rows.all(|(a, b)| {
                    is_same_stop(a, b) && a.time_s == b.time_s && is_same(a.value_um, b.value_um)
                })
        };
        match once.iter().find(is_repeated) {
            Some(first) => notices.push(format!(
                "{}: its readings are those of {}, one by one: the same file twice, or a wrong one; they were judged once",
                verification.name, first.name
            )),
            None => once.push(verification),
        }
    }
    once
}

fn is_same_stop(a: &VerificationReading, b: &VerificationReading) -> bool {
    (a.cycle, a.direction) == (b.cycle, b.direction) && a.positions == b.positions
}

/// Removes rows that repeat earlier ones: six or more consecutive ones of the same cycle, side, positions, reading
/// and time; a notice says which. Without a clock or a second cycle a machine may have come again and shown the same.
pub(crate) fn keep_rows_given_once(verification: &mut Verification) -> Option<String> {
    let readings = &verification.readings;
    let timed = are_timed(readings);
    let has_cycles = readings.windows(2).any(|two| two[0].cycle != two[1].cycle);
    if !timed && !has_cycles {
        return None;
    }
    // No negative zero.
    let bits = |x: f64| (x + 0.0).to_bits();
    let (mut first, mut stop) = (HashMap::new(), 0);
    let mut again: Vec<bool> = Vec::with_capacity(readings.len());
    for (row, reading) in readings.iter().enumerate() {
        if row > 0 && !is_same_stop(&readings[row - 1], reading) {
            stop += 1;
        }
        let positions: Vec<u64> = reading.positions.iter().map(|q| bits(*q)).collect();
        let time = reading.time_s.map(bits);
        let value = bits(reading.value_um);
        let key = (reading.cycle, reading.direction, positions, value, time);
        // Readings of one stop may be equal.
        again.push(*first.entry(key).or_insert(stop) < stop);
    }
    let mut row = 0;
    let mut line = None;
    let mut count = 0;
    for part in again.chunk_by_mut(|a, b| a == b) {
        if part[0] && part.len() < LEAST_REPEATED {
            part.fill(false);
        } else if part[0] {
            line = line.or(Some(readings[row].line));
            count += part.len();
        }
        row += part.len();
    }
    let line = line?;
    let mut again = again.into_iter();
    verification
        .readings
        .retain(|_| !again.next().unwrap_or_default());
    Some(format!(
        "{}: {count} rows from line {line} on repeat earlier ones with the same cycle, direction, positions and reading; they were \
         judged once",
        verification.name
    ))
}

/// Expected number of runs of equal rows of this length, below which a run is no chance: coarse rows are often equal.
const BY_CHANCE: f64 = 1e-4;

/// Most rows for which it is sought: every row is compared with every other.
const MOST_ROWS: usize = 10_000;

/// Consecutive rows that equal later ones.
#[derive(Default)]
struct Run {
    first: usize,
    rows: usize,
    apart: usize,
}

/// Names the longest run of rows that repeats an earlier one, if chance does not explain it.
pub(crate) fn copied(readings: &[VerificationReading]) -> Option<String> {
    if readings.len() > MOST_ROWS {
        return None;
    }
    let mut longest = Run::default();
    let (mut comparable, mut equal) = (0_usize, 0_usize);
    let mut furthest = 0.0_f64;
    for apart in 1..readings.len() {
        let mut rows = 0;
        for (first, (a, b)) in readings.iter().zip(&readings[apart..]).enumerate() {
            let is_comparable = a.direction == b.direction && a.positions == b.positions;
            let is_equal = is_comparable && is_same(a.value_um, b.value_um);
            comparable += usize::from(is_comparable);
            if is_comparable {
                furthest = furthest.max((a.value_um - b.value_um).abs());
            }
            equal += usize::from(is_equal);
            rows = if is_equal { rows + 1 } else { 0 };
            // It must not overlap itself.
            if rows > longest.rows && rows <= apart {
                longest = Run {
                    first: first + 1 - rows,
                    rows,
                    apart,
                };
            }
        }
    }
    if is_coarse(readings, furthest) {
        return None;
    }
    let Run { first, rows, apart } = longest;
    let chance = (equal + 1 - rows) as f64 / (comparable + 1) as f64;
    // A value that comes again within the run is as likely in any row nearby: what hardly changes says nothing.
    let run = &readings[first..first + rows];
    let again = |own: &VerificationReading| {
        let alike = run
            .iter()
            .filter(|other| is_same(own.value_um, other.value_um));
        (alike.count() - 1) as f64 / (rows.max(2) - 1) as f64
    };
    let chances = run.iter().map(|own| again(own).max(chance));
    let expected = comparable as f64 * chances.product::<f64>();
    if rows < LEAST_REPEATED || expected > BY_CHANCE {
        return None;
    }
    let line = |row: usize| readings[row].line;
    Some(format!(
        "the readings in lines {} to {} are those in lines {} to {}, one by one: were they pasted twice? Each counts as a measurement of \
         its own, which makes the result look more certain than it is; remove those that were not measured",
        line(first + apart),
        line(first + apart + rows - 1),
        line(first),
        line(first + rows - 1)
    ))
}

/// Most steps of the last digit over the range of the readings with which it hides the differences of repeats.
const COARSE: f64 = 50.0;

/// Whether repeats differ by at most one digit, of few over the range: a coarse instrument shows the same twice.
fn is_coarse(readings: &[VerificationReading], furthest_um: f64) -> bool {
    let values = || readings.iter().map(|reading| reading.value_um);
    let [low, high] = extremes(values());
    let is_digit = |digit: &f64| {
        let steps = |value: f64| (value / digit - (value / digit).round()).abs();
        values().all(|value| steps(value) < ROUNDING)
    };
    let digits = (-4..4)
        .rev()
        .flat_map(|power| [5.0, 2.0, 1.0].map(|x| x * 10_f64.powi(power)));
    let mut digits = digits.filter(is_digit);
    let digit = digits.next().unwrap_or(0.0);
    high - low <= COARSE * digit && furthest_um <= digit * (1.0 + ROUNDING)
}

/// Rounding error of a number of digits.
const ROUNDING: f64 = 1e-6;

/// A notice where `verification` reads most of the positions of one `before`, of the same points of the machine.
pub(crate) fn read_again(verification: &Verification, before: &[Verification]) -> Option<String> {
    let is_again = |earlier: &&Verification| {
        let is_there = |at: &[f64]| earlier.readings.iter().any(|r| are_same(&r.positions, at));
        let again = verification.readings.iter();
        let again = again.filter(|r| is_there(&r.positions));
        earlier.kind == verification.kind && 2 * again.count() > verification.readings.len()
    };
    let earlier = before.iter().find(is_again)?;
    Some(format!(
        "{}: it reads the positions of {} again; without a calibration each table has a mean curve of its own, and how they differ is not \
         judged: if nothing was changed in between, give them as cycles of one table",
        verification.name, earlier.name
    ))
}
