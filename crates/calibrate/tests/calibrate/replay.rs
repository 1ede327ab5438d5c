//! A calibration that is replayed with other errors of the lengths against the whole calibration of those lengths.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Method, Settings, calibrate, calibrate_for_replay};
use trueaxis_kinematics::MICROMETRE;
use trueaxis_simulate::{NoiseSpec, Scenario};

use crate::with_one_reflector;

const SCENARIOS: [&str; 3] = [
    include_str!("../../../../campaigns/fxyz/scenario.json"),
    include_str!("../../../../campaigns/rotary-stage/scenario.json"),
    include_str!("../../../../campaigns/five-axis/scenario.json"),
];

/// Errors of a nanometre, so small that the declared noise stays as it is. A replay keeps weights, operators and average lines;
/// these depend on errors in second order only.
#[test]
fn a_replay_is_the_whole_calibration_of_the_same_lengths() {
    let methods = [Method::Joint, Method::Nine];
    for (scenario, method) in SCENARIOS.iter().flat_map(|s| methods.map(|m| (s, m))) {
        let mut scenario = Scenario::from_json(scenario).unwrap();
        scenario.noise = NoiseSpec {
            length_sigma_um: Some(0.0),
            length_sigma_ppm: Some(0.0),
            repeatability_um: Some(0.0),
            exact: true,
        };
        let campaign = with_one_reflector(&scenario);
        let settings = Settings {
            method,
            robust: false,
            ..Settings::default()
        };
        let (calibration, replay) = calibrate_for_replay(&campaign, &settings).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut with_errors = campaign.clone();
        let lengths = with_errors.lengths.as_mut().unwrap();
        let errors_mm: Vec<f64> = lengths
            .readings
            .iter_mut()
            .map(|reading| {
                let normal: f64 = StandardNormal.sample(&mut rng);
                let error_mm = 1e-3 * MICROMETRE * normal;
                reading.length_mm += error_mm;
                error_mm
            })
            .collect();
        let changes = replay.responses().to(&errors_mm);
        let whole = calibrate(&with_errors, &settings).unwrap();
        let whole = whole.results().into_iter().filter(|result| result.u > 0.0);
        let mut largest = (0.0_f64, 0.0_f64);
        for ((replayed, before), after) in changes.iter().zip(replay.results()).zip(whole) {
            let u = before.u / before.output.unit().size();
            let expected = (after.value - before.value) / before.output.unit().size();
            largest.0 = largest.0.max((replayed - expected).abs() / u);
            largest.1 = largest.1.max(expected.abs() / u);
        }
        let (difference, change) = largest;
        println!(
            "{}: changes up to {change:.1e} u, differences {difference:.1e} u",
            calibration.campaign
        );
        assert!(difference < 1e-4 * change, "{difference:e}");
    }
}
