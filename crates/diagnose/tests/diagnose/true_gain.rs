//! The gain that a diagnosis claims against the gain on fresh measurements of the same machine.
//!
//! A campaign with an effect is diagnosed. Then the same machine, with the same effect, is measured again and again with
//! fresh noise: every length is predicted to be that of the first campaign less its residual in the calibration with and
//! without what was found. The ratio of what the two leave of the fresh lengths is the true one.

use nalgebra::{DMatrix, DVector, Point3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::{Calibration, calibrate};
use trueaxis_campaign::{Campaign, Stop, Target};
use trueaxis_diagnose::{Cause, Gain, HeldOutRatio, Settings, diagnose};
use trueaxis_effects::Level;
use trueaxis_kinematics::{Ideal, MICROMETRE};
use trueaxis_simulate::{Scenario, simulate};

use crate::machines::generator;
use crate::report;

const FXYZ: &str = include_str!("../../../../campaigns/fxyz/scenario.json");
const ROTARY: &str = include_str!("../../../../campaigns/rotary-stage/scenario.json");

/// Fresh campaigns behind each true ratio.
const FRESH: u64 = 4;

/// A disturbance of random size that shows clearly to hardly.
fn disturbed(mut scenario: Scenario, generator: &mut ChaCha8Rng) -> Scenario {
    let size = 4.0 * 4.0_f64.powf(generator.random());
    let mut component = || size * generator.random_range(-1.0..1.0);
    let vector = |name: &str, v: [f64; 3]| -> String {
        let parts = ["x", "y", "z"].iter().zip(v).map(|(axis, value)| {
            format!(r#"{{ "name": "{name}_{axis}", "value": {value}, "unit": "um" }}"#)
        });
        parts.collect::<Vec<_>>().join(", ")
    };
    let v = [component(), component(), component()];
    let station = &scenario.stations[generator.random_range(0..scenario.stations.len())].name;
    let time_s = generator.random_range(500.0..2500.0);
    let time = format!(r#"{{ "name": "time", "value": {time_s}, "unit": "s" }}"#);
    let effect = match generator.random_range(0..4) {
        0 => format!(
            r#"[{{ "effect": "station_drift", "subject": {{ "station": "{station}" }}, "parameters": [{}] }}]"#,
            vector("creep", v)
        ),
        1 => format!(
            r#"[{{ "effect": "machine_shift", "subject": {{}}, "parameters": [{}, {time}] }}]"#,
            vector("shift", v)
        ),
        2 => format!(
            r#"[{{ "effect": "target_slip", "subject": {{ "target": "Q" }}, "parameters": [{}, {time}] }}]"#,
            vector("slip", v)
        ),
        _ => format!(
            r#"[{{ "effect": "dead_path_drift", "subject": {{ "station": "{station}" }}, "parameters": [{{ "name": "rate_{station}", "value": {}, "unit": "um" }}] }}]"#,
            v[0]
        ),
    };
    scenario.effects = serde_json::from_str(&effect).unwrap();
    scenario
}

/// What a calibration of `first` leaves of the lengths of `fresh`: squares in units of the noise, whose part that the machine
/// returns with is common to a stop. Places and beams are the nominal ones.
fn squares_left(
    calibration: &Calibration,
    stations: &[Point3<f64>],
    first: &Campaign,
    fresh: &Campaign,
) -> f64 {
    let (lengths, measured) = (
        first.lengths.as_ref().unwrap(),
        fresh.lengths.as_ref().unwrap(),
    );
    let mut predicted_mm: Vec<f64> = lengths.readings.iter().map(|r| r.length_mm).collect();
    assert_eq!(calibration.residuals.len(), predicted_mm.len());
    for residual in &calibration.residuals {
        predicted_mm[residual.reading] -= residual.residual_mm;
    }
    let own_mm = first.instrument.length_sigma_um.unwrap() * MICROMETRE;
    let return_mm = first.instrument.repeatability_um.unwrap() * MICROMETRE;
    let beam = |stop: &Stop, target: usize| -> Vector3<f64> {
        let Target {
            carrier, home_mm, ..
        } = &first.targets[target];
        let positions = &first.steps[stop.step].positions;
        let point: Point3<f64> = first
            .machine
            .position(&Ideal, *carrier, positions, *home_mm);
        (point - stations[stop.station]).normalize()
    };
    let of_stop = |stop: &Stop| -> f64 {
        let readings = stop.readings.clone();
        let left = readings
            .clone()
            .map(|i| measured.readings[i].length_mm - predicted_mm[i]);
        let left = DVector::from_iterator(readings.len(), left);
        let beams: Vec<_> = readings
            .map(|i| beam(stop, lengths.readings[i].target))
            .collect();
        let covariance = DMatrix::from_fn(left.len(), left.len(), |i, j| {
            let own = if i == j { own_mm * own_mm } else { 0.0 };
            own + return_mm * return_mm * beams[i].dot(&beams[j])
        });
        covariance.cholesky().unwrap().solve(&left).dot(&left)
    };
    lengths.stops.iter().map(of_stop).sum()
}

/// What a diagnosis says of the gain in the lengths; none if no cause was found.
fn gain_and_calibration(campaign: &Campaign) -> Option<(Gain, Calibration)> {
    let diagnosis = diagnose(campaign, &Settings::default()).unwrap();
    let of_lengths = |cause: &Cause| cause.level == Level::Lengths;
    if !diagnosis.causes.iter().any(of_lengths) {
        return None;
    }
    let levels = diagnosis.levels.into_iter();
    let gain = levels
        .filter(|l| l.level == Level::Lengths)
        .find_map(|l| l.gain)?;
    Some((gain, diagnosis.calibration?))
}

/// The true ratio of a case, and what is said of it; none if no cause was found.
fn case(seed: u64, scenario: &str) -> Option<(f64, Gain)> {
    let mut generator = generator(seed);
    let scenario = disturbed(Scenario::from_json(scenario).unwrap(), &mut generator);
    let measured = |seed: u64| simulate(&scenario, seed).unwrap().campaign;
    let campaign = measured(1000 * seed);
    let (gain, extended) = gain_and_calibration(&campaign)?;
    let mut as_they_are = Settings::default().calibration;
    as_they_are.poses.robust = false;
    let plain = calibrate(&campaign, &as_they_are).unwrap();
    let stations = scenario
        .stations
        .iter()
        .map(|s| Point3::from(s.position_mm));
    let stations: Vec<_> = stations.collect();
    let (mut before, mut after) = (0.0, 0.0);
    for repetition in 1..=FRESH {
        let fresh = measured(1000 * seed + repetition);
        before += squares_left(&plain, &stations, &campaign, &fresh);
        after += squares_left(&extended, &stations, &campaign, &fresh);
    }
    Some(((after / before).sqrt(), gain))
}

/// Cases with a cause, those whose 95 % interval holds the true ratio, those without a gain, and of these those where one is
/// claimed.
#[derive(Debug, Default, Clone, Copy)]
struct Counts {
    cases: usize,
    inside: usize,
    without_gain: usize,
    false_claims: usize,
}

fn count(seeds: std::ops::Range<u64>, scenario: &str) -> Counts {
    let mut counts = Counts::default();
    for seed in seeds {
        let Some((truth, gain)) = case(seed, scenario) else {
            report(&format!("  seed {seed}: no cause named"));
            continue;
        };
        let [low, high] = gain.interval;
        let is_inside = (low..=high).contains(&truth);
        report(&format!(
            "  seed {seed}: true {truth:.4}, held out {:.4} ({low:.4} to {high:.4}){}",
            gain.heldout_rms_ratio,
            if is_inside { "" } else { "  outside" }
        ));
        counts.cases += 1;
        counts.inside += usize::from(is_inside);
        counts.without_gain += usize::from(truth >= 1.0);
        counts.false_claims += usize::from(truth >= 1.0 && gain.is_claimed());
    }
    report(&format!("{counts:?}"));
    counts
}

/// Of 4 cases right intervals lose more than one in 1 of 70 sets of seeds.
#[test]
fn the_interval_holds_the_true_gain() {
    let found = count(0..4, ROTARY);
    assert!(
        found.cases >= 3 && found.inside + 1 >= found.cases,
        "{found:?}"
    );
    assert_eq!(found.false_claims, 0);
}

/// The figures in docs/diagnosis-tests.md: of 137 cases right intervals lose more than 13 with a probability of
/// 9e-3. Where there is no gain, one is claimed in 2.5 of 100: more than two of ten with a probability of 2e-3.
#[test]
#[ignore = "study: 180 cases of five campaigns"]
fn the_interval_holds_the_true_gain_in_95_of_100() {
    let [rotary, fxyz] = [count(100..220, ROTARY), count(300..360, FXYZ)];
    let (inside, cases) = (rotary.inside + fxyz.inside, rotary.cases + fxyz.cases);
    assert!(cases >= 100, "{cases} named");
    assert!(10 * inside >= 9 * cases, "{inside} of {cases}");
    assert!(rotary.without_gain + fxyz.without_gain <= 10);
    assert!(rotary.false_claims + fxyz.false_claims <= 2);
}

/// Two more stations, and one effect.
fn six_stations(effect: &str) -> Scenario {
    let mut scenario = Scenario::from_json(ROTARY).unwrap();
    for (name, [x, y, z]) in [
        ("S5", [-900.0, 700.0, 500.0]),
        ("S6", [300.0, -900.0, 800.0]),
    ] {
        let mut station = scenario.stations[0].clone();
        name.clone_into(&mut station.name);
        station.position_mm = [x, y, z];
        scenario.stations.push(station);
    }
    scenario.effects = serde_json::from_str(effect).unwrap();
    scenario
}

/// What the others say of each station in turn.
fn stations_out(effect: &str) -> HeldOutRatio {
    let campaign = simulate(&six_stations(effect), 5).unwrap().campaign;
    let (gain, _) = gain_and_calibration(&campaign).unwrap();
    gain.leave_one_station_out.expect("six stations")
}

#[test]
fn a_slip_seen_by_five_stations_predicts_the_sixth() {
    let slip = stations_out(
        r#"[{ "effect": "target_slip", "subject": { "target": "Q" }, "parameters": [
            { "name": "slip_x", "value": 2, "unit": "um" }, { "name": "slip_y", "value": -8, "unit": "um" },
            { "name": "slip_z", "value": 3, "unit": "um" }, { "name": "time", "value": 1800, "unit": "s" }] }]"#,
    );
    assert!(slip.interval[1] < 0.9, "{slip:?}");
}

#[test]
fn a_bump_of_one_station_is_nothing_the_others_know_of() {
    let bump = stations_out(
        r#"[{ "effect": "station_jump", "subject": { "station": "S3" }, "parameters": [
            { "name": "jump_x", "value": 6, "unit": "um" }, { "name": "jump_y", "value": -8, "unit": "um" },
            { "name": "jump_z", "value": 3, "unit": "um" }, { "name": "time", "value": 3200, "unit": "s" }] }]"#,
    );
    assert!(bump.interval[1] >= 0.99 && bump.ratio > 0.9, "{bump:?}");
}
