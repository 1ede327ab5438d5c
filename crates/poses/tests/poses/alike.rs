//! What repeats of a stop have in common is no noise.

use std::f64::consts::TAU;

use trueaxis_campaign::Campaign;
use trueaxis_poses::{Settings, measure};
use trueaxis_simulate::{Scenario, simulate};

/// A campaign of two repeats without declared noise.
fn undeclared(seed: u64) -> Campaign {
    let text = include_str!("../../../../campaigns/fxyz/scenario.json");
    let mut scenario = Scenario::from_json(text).unwrap();
    scenario.repeats = 2;
    let mut campaign = simulate(&scenario, seed).unwrap().campaign;
    campaign.instrument.length_sigma_um = None;
    campaign.instrument.repeatability_um = None;
    campaign
}

fn is_said(campaign: &Campaign) -> bool {
    let measured = measure(campaign, &Settings::default()).unwrap();
    let notices = measured.notices.iter();
    notices.filter(|n| n.contains("no noise")).count() == 1
}

/// A meter whose error comes back with the length: by 0.6 µm in noise of 0.3 µm and a repeatability of 1 µm. The noise that is estimated
/// took it in, and nothing was said.
#[test]
fn an_error_that_repeats_itself_is_not_taken_for_noise() {
    const CAMPAIGNS: u64 = 12;
    let (mut alarms, mut found) = (0, 0);
    for seed in 1..=CAMPAIGNS {
        let mut campaign = undeclared(seed);
        alarms += usize::from(is_said(&campaign));
        let period_mm = 4.0 * 1.5_f64.powi(i32::try_from(seed).unwrap());
        for reading in &mut campaign.lengths.as_mut().unwrap().readings {
            reading.length_mm += 6e-4 * (TAU * reading.length_mm / period_mm).sin();
        }
        found += usize::from(is_said(&campaign));
    }
    println!("{alarms} alarms of {CAMPAIGNS} clean campaigns, {found} of {CAMPAIGNS} errors found");
    assert_eq!(alarms, 0);
    assert!(found >= 11, "{found}");
}
