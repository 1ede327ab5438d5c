//! Nothing hidden: silence.

use rand::RngExt;

use trueaxis_campaign::Verification;
use trueaxis_diagnose::Verdict;

use crate::ball_bar::clean_circle;
use crate::counts::summary;
use crate::iso_run::{curve_um, places, table, values_um};
use crate::{found, generator, report};

fn clean_line(seed: u64) -> Verification {
    let mut generator = generator(seed, 2);
    let sigma_um = 0.3 + 0.7 * generator.random::<f64>();
    let parked: &[f64] = if seed % 4 == 3 {
        &[50.0, 350.0]
    } else {
        &[0.0]
    };
    let cycles = if seed % 4 == 2 { 2 } else { 5 };
    let places = places(cycles, parked, &[2.0]);
    let curve = curve_um(&mut generator);
    let nothing = vec![0.0; places.len()];
    let values = values_um(&places, &curve, &nothing, sigma_um, &mut generator);
    table(&places, &values, seed.is_multiple_of(2))
}

/// Two families at 1 %: 2 % of false alarms at most.
fn assert_silent(of: u64, verification: fn(u64) -> Verification, allowed: usize) {
    let diagnoses = (0..of).map(|seed| found(verification(seed)));
    let alarms = diagnoses.filter(|found| found.verdict != Verdict::Clean);
    let alarms: Vec<String> = alarms.map(|found| summary(&found)).collect();
    report(&format!(
        "{} false alarms of {of}: {alarms:?}",
        alarms.len()
    ));
    assert!(alarms.len() <= allowed, "{alarms:?}");
}

/// At 2 % more than one of twelve comes with a probability of 2e-2, more than one of four with 2e-3; the
/// seeds are fixed.
#[test]
fn clean_readings_raise_no_alarm() {
    assert_silent(12, clean_line, 1);
    assert_silent(4, clean_circle, 1);
}

/// At 2 % more than 9 of 200 come with a probability of 8e-3, more than 4 of 50 with 3e-3; the seeds are
/// fixed.
#[test]
#[ignore = "study: 250 diagnoses"]
fn clean_readings_raise_few_alarms() {
    assert_silent(200, clean_line, 9);
    assert_silent(50, clean_circle, 4);
}
