//! What is taken for an interrupted beam when a zero or a tripod drifts or settles.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_tests::blind::{self, Kind};

/// Campaigns in which an occupation is split, of those that are not refused, and their number.
fn cut(effect: &str, strength: f64, seeds: u64) -> [usize; 2] {
    let kind = Kind::three_axis();
    let mut counts = [0; 2];
    for seed in 0..seeds {
        let hidden = blind::draw(&kind, effect, seed).unwrap();
        let hidden = blind::at_strength(&kind, &hidden, seed, strength);
        let campaign = blind::campaign(&kind, std::slice::from_ref(&hidden), seed);
        if let Ok(found) = calibrate(&campaign, &Settings::default()) {
            counts[0] += usize::from(!found.adjustment.interruptions.is_empty());
            counts[1] += 1;
        }
    }
    println!(
        "{effect}, λ = {strength}: {} of {} are cut",
        counts[0], counts[1]
    );
    counts
}

#[test]
fn a_tripod_that_settles_is_not_cut() {
    assert_eq!(cut("station_settling", 20.0, 4), [0, 4]);
}

#[test]
#[ignore = "study: 128 calibrations"]
fn what_drifts_or_settles_is_not_cut() {
    for effect in [
        "station_settling",
        "station_drift",
        "dead_path_drift",
        "warm_up",
    ] {
        for strength in [10.0, 20.0, 40.0, 80.0] {
            assert_eq!(cut(effect, strength, 8)[0], 0);
        }
    }
}
