//! Lost motion that no drive has, and lost motion at one position only.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::Verification;
use trueaxis_diagnose::{Cause, Diagnosis, Verdict};

use crate::iso_run::table_of_stops;
use crate::machines::normal;
use crate::{found, found_in, generator};

const STOPS: usize = 9;

/// Five cycles over nine stops: deviations of a curve, those of the way back times a factor.
fn exchanged(
    random: &mut ChaCha8Rng,
    factor: f64,
    curve_um: impl Fn(usize) -> f64,
) -> Verification {
    table_of_stops(5, STOPS, &mut |_, forward, stop| {
        let value = curve_um(stop) + 0.3 * normal(random);
        if forward { value } else { factor * value }
    })
}

fn is_lost_motion(cause: &Cause) -> bool {
    ["backlash", "position_dependent_backlash"].contains(&cause.effect.effect.id)
}

fn is_said(found: &Diagnosis) -> bool {
    let mut notices = found.notices.iter();
    notices.any(|notice| notice.contains("no drive in use loses more than"))
}

/// The way back in nanometres, the way there in micrometres: sides that differ by some millimetres are no lost motion, whether all are
/// off to one side, on a slope, or to either side of zero.
#[test]
fn sides_in_unlike_units_are_no_lost_motion() {
    for seed in 0..9 {
        let mut random = generator(seed, 55);
        let slope = random.random_range(0.5..1.5);
        let table = match seed % 3 {
            0 => exchanged(&mut random, 1e3, |stop| 2.0 + slope * stop as f64),
            1 => exchanged(&mut random, 1e3, |stop| slope * (stop as f64 - 4.0)),
            _ => exchanged(&mut random, 1e3, |stop| 3.0 * (slope * stop as f64).sin()),
        };
        let found = found(table);
        assert!(
            !found.causes.iter().any(is_lost_motion),
            "{seed}: {:?}",
            found.causes
        );
        assert_ne!(found.verdict, Verdict::Clean, "{seed}");
        assert!(is_said(&found), "{seed}: {:?}", found.notices);
    }
}

/// Two lines of which the way back has the wrong sign: judged together they have no lost motion, either, and are not in order.
#[test]
fn sides_of_two_lines_with_a_wrong_sign_are_no_lost_motion() {
    for seed in 0..6 {
        let mut random = generator(seed, 58);
        let slope = random.random_range(600.0..900.0);
        let lines = ["one", "two"].map(|name| Verification {
            name: name.into(),
            ..exchanged(&mut random, -1.0, |stop| match seed % 2 {
                0 => slope * (stop as f64 - 4.0),
                _ => 3.0 * slope * (0.7 * stop as f64).sin(),
            })
        });
        let found = found_in(lines.to_vec());
        assert!(
            !found.causes.iter().any(is_lost_motion),
            "{seed}: {:?}",
            found.causes
        );
        assert_ne!(found.verdict, Verdict::Clean, "{seed}");
    }
}

/// The control: the play of a worn drive, up to 0.3 mm.
#[test]
fn a_worn_drive_keeps_its_name() {
    for seed in 0..6 {
        let mut random = generator(seed, 56);
        let most = random.random_range(20.0..300.0);
        let table = table_of_stops(5, STOPS, &mut |_, forward, stop| {
            let x = stop as f64 / (STOPS - 1) as f64;
            let play = most * (-((x - 0.4) / 0.3_f64).powi(2)).exp();
            let side = if forward { -0.5 } else { 0.5 };
            side * play + 0.3 * normal(&mut random)
        });
        let found = found(table);
        assert!(
            found.causes.iter().any(is_lost_motion),
            "{seed}: {:?}",
            found.causes
        );
        assert_eq!(found.verdict, Verdict::Named, "{seed}: {:?}", found.causes);
        assert!(!is_said(&found), "{seed}");
    }
}

/// One position, read from both sides in turn, with noise of 1 µm: lost motion and a drift over all readings.
fn one_position(cycles: u32, lost_um: f64, drift_um: f64, seed: u64) -> Diagnosis {
    let mut random = generator(seed, 57);
    let rows = f64::from(2 * cycles);
    found(table_of_stops(cycles, 1, &mut |row, forward, _| {
        let side = if forward { -0.5 } else { 0.5 };
        side * lost_um + drift_um * row as f64 / rows + normal(&mut random)
    }))
}

/// Ten readings of which either half of the misfit hides the other: lost motion is named alone, the drift with the instrument and the
/// machine as rivals. Ten times the noise over half of the readings, so that a miss has no chance worth a number.
#[test]
fn lost_motion_and_drift_at_one_position_do_not_hide_each_other() {
    for cycles in [5, 6, 8] {
        for seed in 0..6 {
            let found = one_position(cycles, 10.0, 20.0, seed);
            let lost = found.causes.iter().find(|c| is_lost_motion(c));
            let lost = lost.unwrap_or_else(|| panic!("{cycles} {seed}: {:?}", found.causes));
            assert!(lost.rivals.is_empty(), "{:?}", lost.rivals);
            let of_time = |c: &Cause| c.effect.subject.axis.is_none() && !c.rivals.is_empty();
            assert!(
                found.causes.iter().any(of_time),
                "{cycles} {seed}: {:?}",
                found.causes
            );
            assert_eq!(found.verdict, Verdict::Named);
        }
    }
}

/// Readings in order: at 1 % for causes and 1 % for tests of what is left more than 8 of 120 alarm with a probability of 2e-3.
#[test]
fn few_readings_of_one_position_raise_few_alarms() {
    let alarms = (0..120).filter(|&seed| {
        let found = one_position(5 + u32::try_from(seed % 4).unwrap(), 0.0, 0.0, seed);
        found.verdict != Verdict::Clean
    });
    let alarms = alarms.count();
    assert!(alarms <= 8, "{alarms}");
}

/// A scale that grows by 1500 ppm in five cycles, of a whole line or of its two ends alone, each from its own side: more than an axis
/// grows. The zero of the instrument does not wander, no lost motion changes, and the growth is most of the misfit.
#[test]
fn what_grows_too_much_has_no_other_name() {
    for seed in 0..10 {
        let mut random = generator(seed, 58);
        let ends_only = seed % 2 == 1;
        let mut table = table_of_stops(5, STOPS, &mut |row, _, stop| {
            let cycles = row as f64 / (2 * STOPS) as f64;
            1.5 * 50.0 * stop as f64 * cycles / 5.0 + 2.0 * normal(&mut random)
        });
        let is_end = |x: f64, side: f64| if side > 0.0 { x > 399.0 } else { x < 1.0 };
        table
            .readings
            .retain(|own| !ends_only || is_end(own.positions[0], f64::from(own.direction.sign())));
        let found = found(table);
        assert_eq!(found.verdict, Verdict::Unknown, "{seed}");
        assert!(found.disturbances.is_empty(), "{seed}");
        let left = found.unexplained.expect("what is left");
        assert!(left.note.contains("ppm"), "{seed}: {}", left.note);
        assert!(left.share > 0.5, "{seed}: {}", left.share);
    }
}
