//! Lost motion and late time stamps: one pair at one feed, two causes at two.

use super::iso_run::{curve_um, places, table, values_um};
use super::lines::report;
use super::{Counts, found, generator};
use crate::Verdict;
use crate::verification::EntryOutcome;

const SEEDS: u64 = 10;
const SIGMA_UM: f64 = 0.5;

/// Readings on the fly with lost motion (µm) or late time stamps (s).
fn outcome(lost_um: f64, late_s: f64, speeds: &[f64], seed: u64) -> EntryOutcome {
    let mut generator = generator(seed, 3);
    let places = places(6, &[0.0], speeds);
    let disturbance: Vec<f64> = places
        .iter()
        .map(|p| -0.5 * lost_um * p.speed.signum() + late_s * 1e3 * p.speed)
        .collect();
    let curve = curve_um(&mut generator);
    let values = values_um(&places, &curve, &disturbance, SIGMA_UM, &mut generator);
    found(table(&places, &values, true))
}

#[test]
fn at_one_feed_they_cannot_be_told_apart() {
    for seed in 0..SEEDS {
        for (lost_um, late_s) in [(2.0, 0.0), (0.0, 4e-5)] {
            let found = outcome(lost_um, late_s, &[25.0], seed);
            assert_eq!(found.verdict, Verdict::Ambiguous, "{seed}");
            let cause = &found.causes[0];
            let rivals = cause.rivals.iter().map(|r| r.effect.effect.id());
            let names: Vec<&str> = rivals.chain([cause.effect.effect.id()]).collect();
            assert!(names.contains(&"backlash"), "{seed} {names:?}");
            assert!(names.contains(&"timestamp_offset"), "{seed} {names:?}");
        }
    }
}

/// λ is 30 for the lost motion and the largest part of it for the time stamps.
#[test]
fn at_two_feeds_each_is_named() {
    let cases = [(2.0, 0.0, "backlash"), (0.0, 4e-5, "timestamp_offset")];
    for (lost_um, late_s, effect) in cases {
        let mut counts = Counts::default();
        for seed in 0..SEEDS {
            counts.add(&outcome(lost_um, late_s, &[10.0, 40.0], seed), effect, Some(0));
        }
        report(&format!("two feeds: {effect}: {counts:?}"));
        assert_eq!(counts.named, SEEDS as usize, "{effect} {counts:?}");
    }
}
