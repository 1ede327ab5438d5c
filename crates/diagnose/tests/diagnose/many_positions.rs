//! Error curves of hundreds of positions, with waves that every second of these, or every seventh, would show as longer ones.

use std::f64::consts::TAU;

use rand::RngExt;
use trueaxis_campaign::Verification;
use trueaxis_diagnose::{Cause, Diagnosis};

use crate::iso_run::table_of_stops;
use crate::machines::normal;
use crate::{found, generator};

const SIGMA_UM: f64 = 0.3;

/// One pass over so many positions 1 mm apart: a wave of 2 µm on a curve that bends by 8 µm.
fn line(positions: usize, period_mm: f64, seed: u64) -> Verification {
    let mut random = generator(seed, 61);
    let phase: f64 = random.random_range(0.0..TAU);
    let mut table = table_of_stops(1, positions, &mut |_, _, stop| {
        let x = stop as f64;
        let bend = 8.0 * (2.0 * x / positions as f64).sin();
        let wave = 2.0 * (TAU * x / period_mm + phase).sin();
        bend + wave + SIGMA_UM * normal(&mut random)
    });
    table.readings.truncate(positions);
    for reading in &mut table.readings {
        reading.positions[0] /= 50.0;
    }
    table
}

fn waves(found: &Diagnosis) -> Vec<&Cause> {
    let waves = found.causes.iter();
    waves
        .filter(|c| c.effect.effect.id == "cyclic_error")
        .collect()
}

/// Amplitude and period within four standard uncertainties of the truth, and nothing else.
fn assert_is(found: &Diagnosis, period_mm: f64) {
    let [wave] = waves(found)[..] else {
        panic!("{period_mm}: {:?}", found.causes);
    };
    for (name, truth) in [("period", period_mm), ("amplitude", 2.0)] {
        let own = wave.parameters.iter().find(|p| p.name == name).unwrap();
        let error = (own.value - truth).abs();
        assert!(
            own.u > 0.0 && error < 4.0 * own.u,
            "{period_mm}: {name} {} ± {}",
            own.value,
            own.u
        );
    }
    assert!(wave.rivals.is_empty(), "{:?}", wave.rivals);
}

/// Every seventh of 400 positions shows a wave of 12.0 mm as one of 16.8 mm.
#[test]
fn a_short_wave_among_400_positions_keeps_its_period() {
    let found = found(line(400, 12.0, 0));
    assert_is(&found, 12.0);
    let is_of_left_out = |notice: &String| notice.contains("positions one in");
    assert!(
        !found.notices.iter().any(is_of_left_out),
        "{:?}",
        found.notices
    );
}

/// Of 500 positions every second is used, which shows a wave of 2.7 mm as one of 7.7 mm: those between tell them apart, and it is
/// said that not all were used. Nor is a wave of 7.7 mm taken for one of 2.7 mm.
#[test]
fn where_positions_are_left_out_they_tell_which_wave_it_is() {
    for (seed, period_mm) in [2.7, 5.4 / 0.7].into_iter().enumerate() {
        let found = found(line(500, period_mm, seed as u64));
        assert_is(&found, period_mm);
        let is_said = |notice: &String| notice.contains("of its 500 positions one in 2");
        assert!(found.notices.iter().any(is_said), "{:?}", found.notices);
    }
}
