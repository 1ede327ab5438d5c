//! Tripods that settle, taken out of the lengths: what is left is as good as it says.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trueaxis_calibrate::{Method, calibrate, calibrate_with_effects};
use trueaxis_diagnose::diagnose;
use trueaxis_effects::GivenEffect;
use trueaxis_poses::scene_of;
use trueaxis_simulate::{Scenario, simulate};
use trueaxis_tests::estimators::{SCENARIOS, settings};
use trueaxis_tests::{Kind, Scatter};

/// Standard deviation of each coordinate by which a tripod stands away from its last place when its occupation begins.
const SETTLING_UM: f64 = 15.0;

/// A tripod, or all alike, that settles within 3 to 30 % of an occupation of `occupation_s`.
fn settling(random: &mut ChaCha8Rng, stations: &[&str], occupation_s: f64) -> GivenEffect {
    let place = random.random_range(0..=stations.len());
    let subject = stations.get(place).map_or(
        serde_json::json!({}),
        |name| serde_json::json!({ "station": name }),
    );
    let time_constant_s = occupation_s * 0.03 * 10_f64.powf(random.random::<f64>());
    let mut parameters: Vec<_> = ["x", "y", "z"]
        .map(|axis| {
            let size: f64 = random.sample(StandardNormal);
            serde_json::json!({ "name": format!("settling_{axis}"), "value": SETTLING_UM * size, "unit": "um" })
        })
        .to_vec();
    parameters.push(
        serde_json::json!({ "name": "time_constant", "value": time_constant_s, "unit": "s" }),
    );
    let effect = serde_json::json!({ "effect": "station_settling", "subject": subject, "parameters": parameters });
    serde_json::from_value(effect).unwrap()
}

/// Campaigns of a shipped machine, each with other tripods that settle: diagnosed, and calibrated again without what was
/// found; beside it calibrated as they are, and the number of those in which nothing was named.
fn without_settling(machine: usize, seeds: std::ops::Range<u64>) -> (Scatter, Scatter, usize) {
    let (mut without, mut with, mut unnamed) = (Scatter::default(), Scatter::default(), 0);
    let scenario = Scenario::from_json(SCENARIOS[machine].1).unwrap();
    let settings = settings(&scenario, Method::Joint);
    for seed in seeds {
        let clean = simulate(&scenario, seed).unwrap().campaign;
        let readings = &clean.lengths.as_ref().unwrap().readings;
        let span_s = readings[readings.len() - 1].time_s - readings[0].time_s;
        let stations: Vec<&str> = clean.stations.iter().map(|s| s.name.as_str()).collect();
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut settles = scenario.clone();
        settles.effects = vec![settling(
            &mut random,
            &stations,
            span_s / stations.len() as f64,
        )];
        let simulated = simulate(&settles, seed).unwrap();
        let explained = trueaxis_diagnose::Settings {
            explain_curves: false,
            ..Default::default()
        };
        let diagnosis = diagnose(&simulated.campaign, &explained).unwrap();
        if let Ok(calibration) = calibrate(&simulated.campaign, &settings) {
            with.add(&calibration, &simulated.truth);
        }
        let effects = diagnosis.effects_file();
        if effects.effects.is_empty() {
            let size = &settles.effects[0];
            println!(
                "seed {seed}: {}, nothing named: {size:?}",
                diagnosis.verdict.name()
            );
            unnamed += 1;
            continue;
        }
        let effects = effects.resolve(&scene_of(&simulated.campaign)).unwrap();
        let calibration = calibrate_with_effects(&simulated.campaign, &effects, &settings).unwrap();
        without.add(&calibration, &simulated.truth);
    }
    (without, with, unnamed)
}

/// As stated within `times` standard errors of the scatter between campaigns, without what was found. Where the tripods
/// stand is not asked: what settles at the first one is, in the lengths, a machine that warms up, and then it stands elsewhere.
fn assert_is_as_stated(machines: &[usize], seeds: &std::ops::Range<u64>, times: f64) {
    let mut off = Vec::new();
    for &machine in machines {
        let name = SCENARIOS[machine].0;
        let (without, with, unnamed) = without_settling(machine, seeds.clone());
        println!("{name}: {unnamed} of {} unnamed", seeds.end - seeds.start);
        for kind in without.kinds() {
            let pooled = without.pooled(|d| d.kind == kind);
            let left_in = with.pooled(|d| d.kind == kind);
            println!("{name}, {kind}: {pooled}; left in: {left_in}");
            let of_tripod = matches!(kind, Kind::Station | Kind::DeadPath);
            if !of_tripod && !pooled.is_as_stated(times) {
                off.push(format!("{name}, {kind}: {pooled}"));
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

/// One of 16 numbers is off by chance with a probability below 1e-2 (Student's, 9 degrees of freedom).
#[test]
fn what_settles_can_be_taken_out() {
    assert_is_as_stated(&[1], &(0..10), 5.5);
}

/// One of some 30 numbers is off by chance with a probability of 8 %; the seeds are fixed.
#[test]
#[ignore = "study: 600 diagnoses"]
fn what_settles_can_be_taken_out_of_300_campaigns() {
    assert_is_as_stated(&[0, 1], &(1000..1300), 3.0);
}
