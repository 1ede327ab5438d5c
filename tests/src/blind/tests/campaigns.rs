//! Campaigns as the other crates see them.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::read;

use super::kinds;
use crate::blind::{Kind, campaign, draw, write};

#[test]
fn campaigns_can_be_written_and_read() {
    for kind in kinds() {
        let folder = tempfile::tempdir().unwrap();
        let hidden = draw(&kind, "machine_shift", 4).unwrap();
        let path = write(&kind, std::slice::from_ref(&hidden), 4, folder.path()).unwrap();
        let mut back = read(&path).unwrap();
        assert_eq!(back.notices, Vec::<String>::new());
        let written = campaign(&kind, &[hidden], 4);
        // Degrees may come back one unit in the last place away.
        for (step, own) in back.steps.iter_mut().zip(&written.steps) {
            for (q, own) in step.positions.iter_mut().zip(&own.positions) {
                assert!((*q - own).abs() < 1e-14);
                *q = *own;
            }
        }
        assert_eq!(back.steps, written.steps);
        assert_eq!(back.lengths, written.lengths);
        assert_eq!(back.targets, written.targets);
    }
}

/// The same machine and noise with and without a disturbance; another seed is another machine.
#[test]
fn the_seed_draws_the_machine_and_the_noise() {
    let kind = Kind::three_axis();
    let hidden = draw(&kind, "machine_shift", 4).unwrap();
    let instant_s = hidden.instant_s().unwrap();
    let lengths = |hidden: &[_], seed| campaign(&kind, hidden, seed).lengths.unwrap().readings;
    let quiet = lengths(&[], 4);
    for (a, b) in quiet.iter().zip(lengths(&[hidden], 4)) {
        let change_um = (b.length_mm - a.length_mm).abs() * 1e3;
        assert_eq!(a.time_s < instant_s, change_um < 1e-9, "at {} s", a.time_s);
        assert!(change_um < 5.0 + 1e-3, "not more than the shift itself");
    }
    let other = lengths(&[], 5);
    assert!(
        quiet
            .iter()
            .zip(&other)
            .all(|(a, b)| (a.length_mm - b.length_mm).abs() > 1e-6)
    );
}

/// An undisturbed campaign calibrates as well as its declared noise says: χ²/ν = 1 within four
/// standard deviations √(2/ν) of it (6e-5 per kind), found by another program than the projection.
#[test]
fn undisturbed_campaigns_calibrate() {
    for kind in kinds() {
        if kind.on_the_fly {
            // Three single targets in one step: the free points of a stop have no common repeatability error.
            continue;
        }
        let calibration = calibrate(&campaign(&kind, &[], 6), &Settings::default()).unwrap();
        let adjustment = &calibration.adjustment;
        assert!(adjustment.rejected.is_empty(), "{kind:?}");
        let spread = (2.0 / adjustment.degrees_of_freedom as f64).sqrt();
        let deviation = (adjustment.sigma0.powi(2) - 1.0) / spread;
        assert!(
            deviation.abs() < 4.0,
            "{kind:?}: sigma0 {}",
            adjustment.sigma0
        );
    }
}
