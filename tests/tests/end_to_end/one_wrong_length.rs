//! One length of 780 that is wrong by 8 µm.
//!
//! The three-axis campaign with one repeat: three lengths at each of 65 steps from each of four stations.
//! Free points leave a redundancy of 185 and hardly see it; rigid stages leave 377, and 8 µm is beyond
//! what the joint adjustment finds with 95 % power at a family-wise 1 %, whichever length it is.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::{Method, Settings, calibrate};
use trueaxis_campaign::Campaign;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::estimators::{METHODS, SCENARIOS};
use trueaxis_tests::in_parallel;

const WRONG_MM: f64 = 8e-3;

/// Counts of campaigns.
#[derive(Debug, Default)]
struct Counts {
    campaigns: usize,
    /// The wrong length was removed.
    found: usize,
    /// Others were removed with it.
    neighbours: usize,
    /// Of the same campaigns without a wrong length: some good one was removed, or all refused.
    clean_that_lose: usize,
}

fn campaign(seed: u64) -> Campaign {
    let mut scenario = Scenario::from_json(SCENARIOS[0].1).unwrap();
    scenario.repeats = 1;
    simulate(&scenario, seed).unwrap().campaign
}

/// The lines that a calibration leaves out; `None` if it is refused.
fn removed(campaign: &Campaign, method: Method) -> Option<Vec<usize>> {
    let mut settings = Settings::default();
    settings.poses.method = method;
    let adjustment = calibrate(campaign, &settings).ok()?.adjustment;
    let rejected = adjustment.rejected.iter().map(|length| length.line);
    adjustment
        .interruptions
        .is_empty()
        .then(|| rejected.collect())
}

fn counts(method: Method, campaigns: u64) -> Counts {
    let one = |seed| {
        let mut campaign = campaign(seed);
        let clean = removed(&campaign, method);
        let readings = &mut campaign.lengths.as_mut().unwrap().readings;
        assert_eq!(readings.len(), 780);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wrong = rng.random_range(0..readings.len());
        let sign = if rng.random::<bool>() { 1.0 } else { -1.0 };
        readings[wrong].length_mm += sign * WRONG_MM;
        let line = readings[wrong].line;
        let removed = removed(&campaign, method).unwrap_or_default();
        let is_found = removed.contains(&line);
        Counts {
            campaigns: 1,
            found: usize::from(is_found),
            neighbours: usize::from(is_found && removed.len() > 1),
            clean_that_lose: usize::from(clean.is_none_or(|lines| !lines.is_empty())),
        }
    };
    let sum = |a: Counts, b: Counts| Counts {
        campaigns: a.campaigns + b.campaigns,
        found: a.found + b.found,
        neighbours: a.neighbours + b.neighbours,
        clean_that_lose: a.clean_that_lose + b.clean_that_lose,
    };
    in_parallel(0..campaigns, one)
        .into_iter()
        .fold(Counts::default(), sum)
}

/// What is claimed of the joint adjustment alone.
fn joint() -> impl Iterator<Item = (&'static str, Method)> {
    METHODS.into_iter().filter(|(name, _)| *name == "joint")
}

/// With a power of 99 % one of ten is missed with a probability of 10 %, two with 0.4 %; the seeds are
/// fixed.
#[test]
fn one_wrong_length_is_found() {
    for (name, method) in joint() {
        let counts = counts(method, 10);
        println!("{name}: {counts:?}");
        assert!(counts.found >= 9, "{name}: {counts:?}");
        assert!(counts.neighbours <= 1, "{name}: {counts:?}");
        assert!(counts.clean_that_lose <= 1, "{name}: {counts:?}");
    }
}

/// With a power of 99 % fewer than 95 of 100 are found with a probability of 5e-4; at a family-wise 1 % more
/// than 4 clean campaigns lose a length with 3e-3. The seeds are fixed.
#[test]
#[ignore = "study: 200 calibrations with each method"]
fn one_wrong_length_is_found_in_95_of_100() {
    for (name, method) in METHODS {
        println!("{name}: {:?}", counts(method, 100));
    }
    for (name, method) in joint() {
        let counts = counts(method, 100);
        assert!(counts.found >= 95, "{name}: {counts:?}");
        assert!(counts.neighbours <= 5, "{name}: {counts:?}");
        assert!(counts.clean_that_lose <= 4, "{name}: {counts:?}");
    }
}
