//! Tables without a clock in the orders in which reports print them: sorted by position or side, with the cycle fastest.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationReading};
use trueaxis_diagnose::{Diagnosis, Verdict};

use crate::counts::summary;
use crate::iso_run::table_of_stops;
use crate::{found, generator};

const LOST_UM: f64 = 10.0;

/// Five cycles over nine stops beside a zero that runs away by 30 µm, noise of 0.5 µm; row 47 is off by 40 µm.
fn measured(seed: u64) -> Verification {
    let mut random: ChaCha8Rng = generator(seed, 61);
    table_of_stops(5, 9, &mut |row, forward, stop| {
        let noise: f64 = StandardNormal.sample(&mut random);
        let lost = if forward { -0.5 } else { 0.5 } * LOST_UM;
        let drift = 30.0 * (1.0 - (-(row as f64) / 40.0).exp());
        let wrong = if row == WRONG { 40.0 } else { 0.0 };
        4.0 * (stop as f64).sin() + lost + drift + wrong + 0.5 * noise
    })
}

const WRONG: usize = 47;

/// The same readings sorted by `key`, as lines of a file of their own; and the line of the one that is off.
fn printed<K: Ord>(
    measured: &Verification,
    key: impl Fn(&VerificationReading) -> K,
) -> (Verification, usize) {
    let mut printed = measured.clone();
    let wrong = printed.readings[WRONG].line;
    printed.readings.sort_by_key(key);
    let place = printed.readings.iter().position(|r| r.line == wrong);
    for (row, reading) in printed.readings.iter_mut().enumerate() {
        reading.line = row + 2;
    }
    (printed, place.unwrap() + 2)
}

fn is_backward(r: &VerificationReading) -> bool {
    r.direction == Direction::Backward
}

fn stop(r: &VerificationReading) -> u64 {
    r.positions[0].to_bits()
}

/// What was found, to the last bit.
fn figures(found: &Diagnosis) -> Vec<(&'static str, Vec<[u64; 2]>)> {
    let causes = found.causes.iter();
    let figures = causes.map(|cause| {
        let sizes = cause.parameters.iter();
        let bits = sizes.map(|p| [p.value.to_bits(), p.u.to_bits()]);
        (cause.effect.effect.id, bits.collect())
    });
    figures.collect()
}

/// The order in which a table is printed changes no figure, and the user is told which order was taken.
#[test]
fn printed_orders_show_what_the_measured_one_shows() {
    for seed in 0..2 {
        let measured = measured(seed);
        let expected = found(measured.clone());
        let lost = &expected.causes.iter().find(|c| is_lost_motion(c)).unwrap();
        let size = &lost.parameters[0];
        assert!((size.value - LOST_UM).abs() < 4.0 * size.u, "{size:?}");
        assert!(lost.rivals.is_empty(), "{}", summary(&expected));
        let order = |n: &&String| n.contains("time_s");
        assert_eq!(expected.notices.iter().find(order), None);
        for (table, line) in [
            printed(&measured, |r| (is_backward(r), stop(r), r.cycle)),
            printed(&measured, |r| (stop(r), is_backward(r), r.cycle)),
            printed(&measured, |r| (is_backward(r), r.cycle, stop(r))),
            printed(&measured, |r| (r.cycle, is_backward(r), stop(r))),
        ] {
            let found = found(table);
            assert_eq!(figures(&found), figures(&expected), "{}", summary(&found));
            assert_eq!(found.rejected.len(), 1);
            assert_eq!(found.rejected[0].row, line);
            let said = found.notices.iter().find(order);
            assert!(
                said.is_some_and(|n| n.contains("ISO 230-2")),
                "{:?}",
                found.notices
            );
        }
    }
}

fn is_lost_motion(cause: &trueaxis_diagnose::Cause) -> bool {
    ["backlash", "position_dependent_backlash"].contains(&cause.effect.effect.id)
}

/// All passes there before all passes back: were they measured so, or cycle by cycle? Lost motion is then a jump between the two
/// halves, too, and is not named alone.
#[test]
fn passes_there_before_all_passes_back_name_no_lost_motion_alone() {
    for seed in 0..2 {
        let (table, _) = printed(&measured(seed), |r| {
            let place = if is_backward(r) {
                u64::MAX - stop(r)
            } else {
                stop(r)
            };
            (is_backward(r), r.cycle, place)
        });
        let found = found(table);
        let alone = found
            .causes
            .iter()
            .find(|c| is_lost_motion(c) && c.rivals.is_empty());
        assert!(alone.is_none(), "{}", summary(&found));
        assert!(
            found.notices.iter().any(|n| n.contains("time_s")),
            "{:?}",
            found.notices
        );
    }
}

/// With both sides beside each other a printed table looks like a step cycle, and is taken for one; that cycles differ in it is said.
#[test]
fn sides_beside_each_other_are_a_step_cycle() {
    let says = |found: &Diagnosis| found.notices.iter().any(|n| n.contains("step cycle"));
    for seed in 0..2 {
        let measured = measured(seed);
        for (table, _) in [
            printed(&measured, |r| (stop(r), u64::from(r.cycle), is_backward(r))),
            printed(&measured, |r| (u64::from(r.cycle), stop(r), is_backward(r))),
        ] {
            let found = found(table);
            assert!(says(&found), "{:?}", found.notices);
        }
        // A true one, in which the zero runs away as before.
        let mut random: ChaCha8Rng = generator(seed, 62);
        let (mut stepped, _) = printed(&measured, |r| (stop(r), r.cycle, is_backward(r)));
        for (row, reading) in stepped.readings.iter_mut().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut random);
            let lost = if is_backward(reading) { 0.5 } else { -0.5 } * LOST_UM;
            let drift = 30.0 * (1.0 - (-(row as f64) / 40.0).exp());
            reading.value_um = lost + drift + 0.5 * noise;
        }
        let found = found(stepped);
        assert!(found.notices.is_empty(), "{:?}", found.notices);
        let lost = found.causes.iter().find(|c| is_lost_motion(c)).unwrap();
        let size = &lost.parameters[0];
        assert!((size.value - LOST_UM).abs() < 4.0 * size.u, "{size:?}");
    }
}

/// Passes that all go against their side: the sides are exchanged, the order is that of measuring.
#[test]
fn exchanged_sides_keep_their_order() {
    let mut table = measured(2);
    let expected = found(table.clone());
    for reading in &mut table.readings {
        reading.direction = match reading.direction {
            Direction::Forward => Direction::Backward,
            Direction::Backward => Direction::Forward,
        };
    }
    let found = found(table);
    let size = |found: &Diagnosis| {
        let lost = found.causes.iter().find(|c| is_lost_motion(c));
        lost.map_or(0.0, |c| c.parameters[0].value)
    };
    assert!(
        (size(&found) + size(&expected)).abs() < 0.01,
        "{}",
        summary(&found)
    );
    assert_eq!(found.verdict, Verdict::Named);
    // Beyond where it should be, as a control leaves it that stops at the far edge of its window.
    let lost = found.causes.iter().find(|c| is_lost_motion(c)).unwrap();
    let what = lost.explanation().cause;
    assert!(
        what.contains("far edge") && what.contains("exchanged"),
        "{what}"
    );
    assert!(
        found.notices.iter().any(|n| n.contains("exchanged")),
        "{:?}",
        found.notices
    );
}

/// One side after the other, by the clock, while the zero goes from one value to another: lost motion would look much the same, and
/// was not among what cannot be told apart.
#[test]
fn what_wanders_from_one_side_to_the_other_may_be_lost_motion() {
    let wanders = |by_side: bool, seed: u64| {
        let mut random: ChaCha8Rng = generator(seed, 62);
        let mut table = table_of_stops(5, 9, &mut |_, _, stop| 4.0 * (stop as f64).sin());
        if by_side {
            table.readings.sort_by_key(is_backward);
        }
        for (row, reading) in table.readings.iter_mut().enumerate() {
            let noise: f64 = StandardNormal.sample(&mut random);
            let time = row as f64 / 89.0;
            reading.time_s = Some(10.0 * row as f64);
            reading.value_um += 4.0 * (5.0 * (time - 0.5)).tanh() + 0.5 * noise;
            reading.line = row + 2;
        }
        let found = found(table);
        assert_eq!(found.verdict, Verdict::Unknown, "{}", summary(&found));
        let rivals = found.disturbances[0].rivals.clone();
        rivals.iter().any(|w| w.varies_with.contains(&"direction"))
    };
    for seed in 0..3 {
        assert!(wanders(true, seed));
        assert!(!wanders(false, seed));
    }
}
