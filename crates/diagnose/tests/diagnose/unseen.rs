//! What a table cannot show is said, not denied.

use trueaxis_campaign::{Direction, Verification};
use trueaxis_diagnose::Diagnosis;

use crate::iso_run::{curve_um, places, table, values_um};
use crate::{found, generator};

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

fn unseen(found: &Diagnosis) -> Vec<&'static str> {
    found.not_observable.iter().map(|n| n.effect).collect()
}

#[test]
fn the_mean_curve_hides_scale_and_cyclic_error() {
    // Five positions are too few to look into the curve itself.
    let mut short = line(|_| true);
    short.readings.retain(|reading| reading.positions[0] < 90.0);
    let found = found(short);
    let unseen = unseen(&found);
    for effect in ["scale_error", "cyclic_error", "timestamp_offset"] {
        assert!(unseen.contains(&effect), "{effect} {unseen:?}");
    }
    assert!(!unseen.contains(&"backlash"), "{unseen:?}");
    let scale = found
        .not_observable
        .iter()
        .find(|n| n.effect == "scale_error")
        .unwrap();
    assert!(!scale.bias_per_unit.is_empty(), "{scale:?}");
}

#[test]
fn one_direction_hides_lost_motion() {
    let found = found(line(|direction| direction == Direction::Forward));
    assert!(unseen(&found).contains(&"backlash"), "{:?}", unseen(&found));
}

/// One cycle in one direction is its own mean curve.
#[test]
fn too_little_is_a_notice() {
    let mut once = line(|direction| direction == Direction::Forward);
    once.readings.retain(|reading| reading.cycle == 1);
    let found = found(once);
    assert!(found.levels.is_empty());
    assert!(
        found.notices[0].contains("nothing can be said"),
        "{:?}",
        found.notices
    );
}

/// One cycle there and back: the noise is what the model leaves, 0.5 µm to a fifth or so.
#[test]
fn one_cycle_is_judged_by_what_is_left() {
    let mut once = line(|_| true);
    once.readings.retain(|reading| reading.cycle == 1);
    let found = found(once);
    let floor_um = found.levels[0].noise_floor_um;
    assert!((0.3..0.7).contains(&floor_um), "{floor_um}");
}
