//! Cycles that were pasted, not measured.

use trueaxis_campaign::{Direction, Verification};

use crate::iso_run::table_of_stops;
use crate::machines::normal;
use crate::{found, generator};

/// Six cycles, rounded to a digit; the last three are the first three if they were pasted.
fn table(digit_um: f64, is_pasted: bool, seed: u64) -> Verification {
    let mut random = generator(seed, 67);
    let mut table = table_of_stops(6, 9, &mut |_, _, stop| {
        let value = 0.5 * stop as f64 + normal(&mut random);
        (value / digit_um).round() * digit_um
    });
    let half = table.readings.len() / 2;
    if is_pasted {
        for k in 0..half {
            table.readings[half + k].value_um = table.readings[k].value_um;
        }
    }
    table
}

fn is_said(digit_um: f64, is_pasted: bool, seed: u64) -> bool {
    let found = found(table(digit_um, is_pasted, seed));
    found.notices.iter().any(|notice| notice.contains("pasted"))
}

/// Whole cycles that came again under other numbers were taken for measurements. Of readings to a µm, the scatter of which is one,
/// every third pair is equal, but not fifty in a row.
#[test]
fn pasted_cycles_are_said_and_equal_readings_are_not() {
    for seed in 0..10 {
        for digit_um in [0.01, 1.0] {
            assert!(is_said(digit_um, true, seed), "{digit_um}, seed {seed}");
            assert!(!is_said(digit_um, false, seed), "{digit_um}, seed {seed}");
        }
    }
}

/// An instrument that reads no finer than what repeats differ by reads cycle after cycle the same: two of ten stops each came alike. Where it
/// reads finer they were pasted.
#[test]
fn coarse_digits_are_not_pasted() {
    let is_said = |digit_um: f64, seed: u64| {
        let mut random = generator(seed, 68);
        let mut table = table_of_stops(2, 10, &mut |_, _, stop| {
            let value = 1.5 * (stop * stop) as f64 + 0.5 * normal(&mut random);
            (value / digit_um).round() * digit_um
        });
        let half = table.readings.len() / 2;
        for k in 0..half {
            table.readings[half + k].value_um = table.readings[k].value_um;
        }
        let said = found(table).notices;
        said.iter().any(|notice| notice.contains("pasted"))
    };
    for seed in 0..10 {
        assert!(!is_said(10.0, seed), "seed {seed}");
        assert!(is_said(0.1, seed), "seed {seed}");
    }
}

/// A probe that warms up and settles within its last digit, 1.25 µm, reads dozens of rows alike: that is no copy.
#[test]
fn what_hardly_changes_is_not_pasted() {
    for seed in 0..10 {
        let mut random = generator(seed, 69);
        let mut table = table_of_stops(80, 1, &mut |row, _, _| {
            let value = 90.0 * (1.0 - (-(row as f64) / 20.0).exp()) + 0.25 * normal(&mut random);
            (value / 1.25).round() * 1.25
        });
        for (row, reading) in table.readings.iter_mut().enumerate() {
            reading.cycle = 1 + u32::try_from(row).unwrap();
            reading.direction = Direction::Forward;
        }
        let said = found(table).notices;
        assert!(
            !said.iter().any(|notice| notice.contains("pasted")),
            "{seed}: {said:?}"
        );
    }
}
