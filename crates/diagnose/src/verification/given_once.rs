//! Readings given twice, in two files or within one: as a second measurement they would make everything look more
//! certain than it is.

use std::collections::HashMap;

use trueaxis_campaign::{Verification, VerificationReading};

use crate::verification::arrivals::{are_timed, is_same};
use crate::verification::copied::is_coarse;

/// Consecutive readings from which on two tables, or two parts of one, are the same; fewer may agree by chance.
pub(super) const LEAST_REPEATED: usize = 6;

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
