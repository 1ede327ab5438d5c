//! One cycle there and back, in which every position has one reading from either side.

use std::f64::consts::TAU;

use rand::RngExt;
use trueaxis_campaign::Verification;

use crate::iso_run::table_of_stops;
use crate::machines::normal;
use crate::{found, generator};

const STOPS: usize = 24;

/// Smooth error of 20 µm, lost motion of 3 µm, noise of 1 µm, and `off_um(row, side, stop)`.
fn cycle(seed: u64, off_um: impl Fn(usize, f64, usize) -> f64) -> Verification {
    let mut random = generator(seed, 160);
    table_of_stops(1, STOPS, &mut |row, forward, stop| {
        let side = if forward { 1.0 } else { -1.0 };
        let curve = 20.0 * (TAU * stop as f64 / STOPS as f64).sin();
        curve - 1.5 * side + off_um(row, side, stop) + normal(&mut random)
    })
}

fn left_out(table: Verification) -> Vec<usize> {
    found(table).rejected.iter().map(|own| own.row).collect()
}

/// A reading that is 40 µm off is left out and no other, and the lost motion it hid is found. Those at the ends of the
/// axis are left out together with the other of their position.
#[test]
fn a_wrong_reading_is_left_out() {
    for seed in 0..8 {
        let mut random = generator(seed, 161);
        let wrong = random.random_range(1..STOPS - 1) + STOPS * random.random_range(0..2);
        let table = cycle(seed, |row, _, _| if row == wrong { 40.0 } else { 0.0 });
        let found = found(table);
        let rows: Vec<usize> = found.rejected.iter().map(|own| own.row).collect();
        assert_eq!(rows, [wrong + 2], "{seed}: {:?}", found.notices);
        let mut causes = found.causes.iter();
        assert!(
            causes.any(|own| own.effect.effect.id == "backlash"),
            "{seed}"
        );
        let first = cycle(seed, |row, _, _| if row == 0 { 40.0 } else { 0.0 });
        assert_eq!(left_out(first), [2, 2 * STOPS + 1], "{seed}");
    }
}

/// What machines and instruments do is not left out: a dent that both sides show, a jump, lost motion that differs along
/// the axis or is missing at the turn, waves that the sides show shifted, a warm-up. Noise has an error in 0.1 % of tables,
/// so none of 30 with a probability of 0.97.
#[test]
fn what_is_no_mistake_stays() {
    let is_near = |stop: usize, width: f64| 40.0 * (-(stop as f64 - 9.0).powi(2) / width).exp();
    let cases: [&dyn Fn(usize, f64, usize) -> f64; 6] = [
        &|_, _, stop| if stop == 9 { 40.0 } else { 0.0 },
        &|row, _, _| if row > 9 { 40.0 } else { 0.0 },
        &|_, side, stop| 0.5 * side * is_near(stop, 2.0),
        &|row, _, _| match row {
            ..STOPS => 0.0,
            STOPS => 10.0,
            _ => 40.0,
        },
        &|_, side, stop| 20.0 * (TAU * stop as f64 / 3.3 + side).sin(),
        &|row, _, _| -40.0 * (-(row as f64) / 2.0).exp(),
    ];
    for (number, case) in cases.iter().enumerate() {
        for seed in 0..5 {
            let left_out = left_out(cycle(seed, case));
            assert!(left_out.is_empty(), "{number} {seed}: {left_out:?}");
        }
    }
}
