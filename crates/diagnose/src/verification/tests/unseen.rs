//! What a table cannot show is said, not denied.

use super::iso_run::{curve_um, places, table, values_um};
use super::{campaign, generator, scene};
use crate::verification::{VerificationOutcome, diagnose_verification};
use trueaxis_campaign::{Direction, Verification};

fn line(keep: impl Fn(Direction) -> bool) -> Verification {
    let mut generator = generator(1, 8);
    let places = places(5, &[0.0], &[2.0]);
    let curve = curve_um(&mut generator);
    let nothing = vec![0.0; places.len()];
    let values = values_um(&places, &curve, &nothing, 0.5, &mut generator);
    let mut table = table(&places, &values, false);
    table.readings.retain(|reading| keep(reading.direction));
    table
}

fn outcome(verification: Verification) -> VerificationOutcome {
    let campaign = campaign(vec![verification]);
    diagnose_verification(&campaign, None, &scene(&campaign))
}

fn unseen(outcome: &VerificationOutcome) -> Vec<&'static str> {
    outcome.not_observable.iter().map(|n| n.effect).collect()
}

#[test]
fn the_mean_curve_hides_scale_and_cyclic_error() {
    let outcome = outcome(line(|_| true));
    let unseen = unseen(&outcome);
    for effect in ["scale_error", "cyclic_error", "timestamp_offset"] {
        assert!(unseen.contains(&effect), "{effect} {unseen:?}");
    }
    assert!(!unseen.contains(&"backlash"), "{unseen:?}");
    let scale = outcome
        .not_observable
        .iter()
        .find(|n| n.effect == "scale_error")
        .unwrap();
    assert!(!scale.bias_per_unit.is_empty(), "{scale:?}");
}

#[test]
fn one_direction_hides_lost_motion() {
    let outcome = outcome(line(|direction| direction == Direction::Forward));
    assert!(
        unseen(&outcome).contains(&"backlash"),
        "{:?}",
        unseen(&outcome)
    );
}

/// One cycle in one direction is its own mean curve.
#[test]
fn too_little_is_a_notice() {
    let mut once = line(|direction| direction == Direction::Forward);
    once.readings.retain(|reading| reading.cycle == 1);
    let outcome = outcome(once);
    assert!(outcome.entries.is_empty());
    assert!(
        outcome.notices[0].contains("nothing can be said"),
        "{:?}",
        outcome.notices
    );
}

/// One cycle there and back: the noise is what the model leaves, 0.5 µm to a fifth or so.
#[test]
fn one_cycle_is_judged_by_what_is_left() {
    let mut once = line(|_| true);
    once.readings.retain(|reading| reading.cycle == 1);
    let outcome = outcome(once);
    let floor_um = outcome.entries[0].report.noise_floor_um;
    assert!((0.3..0.7).contains(&floor_um), "{floor_um}");
}
