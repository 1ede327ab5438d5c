//! A calibration that is replayed with other errors of the lengths against the whole calibration of those lengths.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Method, Settings, calibrate, calibrate_for_replay};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::MICROMETRE;
use trueaxis_simulate::{NoiseSpec, Scenario, Term};

use crate::with_one_reflector;

const SCENARIOS: [&str; 3] = [
    include_str!("../../../../campaigns/fxyz/scenario.json"),
    include_str!("../../../../campaigns/rotary-stage/scenario.json"),
    include_str!("../../../../campaigns/five-axis/scenario.json"),
];

/// Lengths without noise of a machine with its errors and `more` of them (µm and ″ over half a travel).
fn exact(scenario: &Scenario, more: f64) -> Campaign {
    let mut scenario = scenario.clone();
    scenario.noise = NoiseSpec::NONE;
    for errors in scenario.errors.values_mut() {
        // No pose has a place for it.
        (errors.lost_motion_um, errors.lost_motion_arcsec) = (None, None);
        let components = errors.components.values_mut();
        for (k, terms) in components.enumerate() {
            let coefficients = vec![0.0, more, 0.3 * more * (k as f64 - 2.0)];
            terms.push(Term::Polynomial { coefficients });
        }
    }
    with_one_reflector(&scenario)
}

/// What a replay makes of a change of the lengths is compared with the calibration of those lengths.
fn assert_replays(what: &str, before: &Campaign, after: &Campaign, method: Method) {
    let mut settings = Settings::default();
    settings.poses.method = method;
    settings.poses.robust = false;
    let lengths = [before, after].map(|campaign| campaign.lengths.as_ref().unwrap());
    let pairs = lengths[0].readings.iter().zip(&lengths[1].readings);
    let errors_mm: Vec<f64> = pairs.map(|(a, b)| b.length_mm - a.length_mm).collect();
    let (_, replay) = calibrate_for_replay(before, &settings).unwrap();
    let changes = replay.responses().to(&errors_mm);
    let whole = calibrate(after, &settings).unwrap();
    let whole: Vec<_> = whole
        .results()
        .into_iter()
        .filter(|result| result.u > 0.0)
        .collect();
    assert_eq!(
        (changes.len(), replay.results().len()),
        (whole.len(), whole.len())
    );
    let (mut difference, mut change) = (0.0_f64, 0.0_f64);
    for ((replayed, before), after) in changes.iter().zip(replay.results()).zip(whole) {
        assert_eq!(before.output, after.output);
        assert!(replayed.is_finite());
        let expected = (after.value - before.value) / before.output.unit().size();
        let u = before.u / before.output.unit().size();
        difference = difference.max((replayed - expected).abs() / u);
        change = change.max(expected.abs() / u);
    }
    println!(
        "{}, {what}: changes up to {change:.1e} u, differences {difference:.1e} u",
        before.name
    );
    assert!(difference < 1e-4 * change, "{difference:e}");
}

/// A replay keeps weights, operators and average lines. Errors of a nanometre leave the declared noise as it is; errors that
/// another machine makes leave nothing in the residuals, so that they may be large.
#[test]
fn a_replay_is_the_whole_calibration_of_the_same_lengths() {
    for scenario in SCENARIOS {
        let scenario = Scenario::from_json(scenario).unwrap();
        let before = exact(&scenario, 0.0);
        let mut with_noise = before.clone();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for reading in &mut with_noise.lengths.as_mut().unwrap().readings {
            let normal: f64 = StandardNormal.sample(&mut rng);
            reading.length_mm += 1e-3 * MICROMETRE * normal;
        }
        let of_another = exact(&scenario, 5.0);
        for method in [Method::Joint, Method::Nine] {
            assert_replays("noise", &before, &with_noise, method);
            assert_replays("another machine", &before, &of_another, method);
        }
    }
}
