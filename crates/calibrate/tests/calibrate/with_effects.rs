//! Effects that are taken out of the lengths.

use trueaxis_calibrate::{
    Calibration, NumberedResult, Settings, calibrate, calibrate_with_effects,
};
use trueaxis_campaign::Campaign;
use trueaxis_effects::{EffectsFile, GivenEffect, ResolvedEffects, resolve_all};
use trueaxis_poses::scene_of;
use trueaxis_simulate::{Scenario, simulate};

const SCENARIO: &str = include_str!("../../../../campaigns/rotary-stage/scenario.json");

/// A target that slips in the second occupation.
const SLIP: &str = r#"{ "format": "trueaxis-effects", "version": 1, "campaign": "Rotary stage",
    "effects": [ { "effect": "target_slip", "subject": { "target": "Q" },
      "parameters": [ { "name": "slip_x", "value": 5, "unit": "um" },
                      { "name": "slip_y", "value": -4, "unit": "um" },
                      { "name": "slip_z", "value": 3, "unit": "um" },
                      { "name": "time", "value": 3000, "unit": "s" } ] } ],
    "covariance": [[0.25, 0.1, 0], [0.1, 0.16, -0.05], [0, -0.05, 0.09]] }"#;

fn campaign(effects: Vec<GivenEffect>) -> Campaign {
    let mut scenario = Scenario::from_json(SCENARIO).unwrap();
    scenario.effects = effects;
    simulate(&scenario, 1).unwrap().campaign
}

fn settings() -> Settings {
    Settings {
        covariance: true,
        ..Settings::default()
    }
}

fn without(campaign: &Campaign, effects: &ResolvedEffects) -> Calibration {
    calibrate_with_effects(campaign, effects, &settings()).unwrap()
}

/// The results that are not defined by gauge or frame.
fn results(calibration: &Calibration) -> Vec<NumberedResult> {
    let all = calibration.results().into_iter();
    all.filter(|result| result.u > 0.0).collect()
}

/// Campaigns of one seed differ by their effects alone.
#[test]
fn right_values_leave_the_calibration_without_effects() {
    let file = EffectsFile::from_json(SLIP).unwrap();
    let disturbed = campaign(file.effects.clone());
    let exact = ResolvedEffects {
        effects: resolve_all(&file.effects, &scene_of(&disturbed)).unwrap(),
        covariance: None,
    };
    let found = results(&without(&disturbed, &exact));
    let clean = results(&calibrate(&campaign(Vec::new()), &settings()).unwrap());
    let plain = results(&calibrate(&disturbed, &settings()).unwrap());
    let off = |found: &[NumberedResult]| {
        let pairs = found.iter().zip(&clean);
        pairs
            .map(|(a, b)| (a.value - b.value).abs() / b.u)
            .fold(0.0, f64::max)
    };
    // The effect is computed at the adjusted geometry, whose datum is turned by 1e-4 rad, and lengths
    // are rounded to 1e-7 mm.
    assert!(off(&found) < 1e-2, "{}", off(&found));
    assert!(off(&plain) > 1.0, "{}", off(&plain));
}

/// `u²` grows by the squares of what one standard deviation along each column of a root of the covariance does,
/// here a Cholesky factor and whole calibrations instead of eigenvectors and trials.
#[test]
fn uncertainty_grows_by_that_of_the_effects() {
    let file = EffectsFile::from_json(SLIP).unwrap();
    let disturbed = campaign(file.effects.clone());
    let resolved = file.resolve(&scene_of(&disturbed)).unwrap();
    let exact = ResolvedEffects {
        covariance: None,
        ..resolved.clone()
    };
    let whole = without(&disturbed, &resolved);
    let (with, known) = (results(&whole), results(&without(&disturbed, &exact)));
    let rows = resolved.covariance.as_ref().unwrap();
    let covariance = nalgebra::DMatrix::from_fn(3, 3, |i, j| rows[i][j]);
    let root = covariance.cholesky().unwrap().unpack();
    let mut grown = vec![0.0; with.len()];
    // Half the difference of both ways: the whole calibrations estimate their noise and so their weights anew,
    // which a difference of one way would hold in second order.
    let moved = |column: &[f64], sign: f64| {
        let mut moved = exact.clone();
        for (value, step) in moved.effects[0].parameters.iter_mut().zip(column) {
            *value += sign * step;
        }
        results(&without(&disturbed, &moved))
    };
    for column in root.column_iter() {
        let column = column.into_owned();
        let ways = [1.0, -1.0].map(|sign| moved(column.as_slice(), sign));
        for ((sum, a), b) in grown.iter_mut().zip(&ways[0]).zip(&ways[1]) {
            *sum += (0.5 * (a.value - b.value)).powi(2);
        }
    }
    let mut largest_share = 0.0_f64;
    for ((with, known), grown) in with.iter().zip(&known).zip(&grown) {
        let expected = known.u.powi(2) + grown;
        let ratio = with.u.powi(2) / expected;
        assert!((ratio - 1.0).abs() < 0.01, "{:?}: {ratio}", with.output);
        largest_share = largest_share.max(grown / expected);
    }
    assert!(largest_share > 0.05, "{largest_share}");
    // The covariance says the same.
    let covariance = whole.covariance.unwrap().matrix;
    let variances = covariance.diagonal();
    let variances = variances.iter().filter(|variance| **variance > 0.0);
    for (variance, result) in variances.zip(&with) {
        let expected = (result.u / result.output.unit().size()).powi(2);
        assert!(
            (variance / expected - 1.0).abs() < 1e-9,
            "{:?}",
            result.output
        );
    }
}
