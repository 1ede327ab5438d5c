//! A campaign and the truth about it give the scenario back: simulated again, it measures the same.

use trueaxis_campaign::Campaign;
use trueaxis_simulate::{ReplayError, Scenario, Simulated, replay, simulate};

use crate::shipped;

/// Twice the grid of the lengths, mm.
const LENGTH_TOL_MM: f64 = 2e-7;

fn simulated(name: &str) -> Simulated {
    simulate(&Scenario::read(shipped::path(name)).unwrap(), 5).unwrap()
}

fn lengths_mm(campaign: &Campaign) -> Vec<f64> {
    let readings = &campaign.lengths.as_ref().unwrap().readings;
    readings.iter().map(|reading| reading.length_mm).collect()
}

#[test]
fn what_was_simulated_is_measured_again() {
    for name in ["fxyz", "rotary-stage"] {
        let Simulated { campaign, truth } = simulated(name);
        let replay = replay(&campaign, &truth).unwrap();
        assert_eq!(replay.notices, [""; 0], "{name}");
        // The same seed has the same noise at the same stops.
        let again = simulate(&replay.scenario, 5).unwrap().campaign;
        assert_eq!(again.steps, campaign.steps, "{name}");
        let pairs = lengths_mm(&again).into_iter().zip(lengths_mm(&campaign));
        let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest <= LENGTH_TOL_MM, "{name}: {largest:e}");
    }
}

/// What is drawn once for a campaign is not drawn again, but taken from the truth.
#[test]
fn what_is_off_in_all_readings_is_measured_again() {
    let mut json = shipped::json("fxyz");
    json["instrument"]["reflector_sigma_um"] = 2.0.into();
    json["instrument"]["scale_sigma_ppm"] = 1.5.into();
    json["targets"][2]["reflector"] = "P".into();
    json["targets"][0]["reflector"] = "P".into();
    let Simulated { campaign, truth } = simulate(&shipped::scenario(&json), 5).unwrap();
    assert!(truth.scale_ppm.abs() > 0.01);
    let replay = replay(&campaign, &truth).unwrap();
    let text = trueaxis_files::to_json(&replay.scenario).unwrap();
    assert_eq!(Scenario::from_json(&text).unwrap(), replay.scenario);
    // Another seed for what is drawn once, the same noise: none.
    let mut exact = replay.scenario.clone();
    exact.noise = serde_json::from_str(
        r#"{ "length_sigma_um": 0, "length_sigma_ppm": 0, "repeatability_um": 0, "exact": true }"#,
    )
    .unwrap();
    let of_seed = |seed| lengths_mm(&simulate(&exact, seed).unwrap().campaign);
    assert_eq!(of_seed(1), of_seed(2));
    let again = simulate(&replay.scenario, 5).unwrap().campaign;
    let pairs = lengths_mm(&again).into_iter().zip(lengths_mm(&campaign));
    let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest <= LENGTH_TOL_MM, "{largest:e}");
}

/// Growth with a temperature: the replay logs what the campaign did, averaged over 40 s, with lines between.
#[test]
fn what_grows_with_a_temperature_grows_again() {
    let mut json = shipped::json("fxyz");
    json["temperatures"] = serde_json::json!([{ "column": "machine_temp_c", "course": [
        { "kind": "sine", "amplitude_k": 2.0, "period_s": 6000.0 } ] }]);
    json["effects"] = serde_json::json!([{ "effect": "thermal_growth",
        "subject": { "axis": "X", "column": "machine_temp_c" }, "parameters": [
            { "name": "expansion", "value": 10.0, "unit": "ppm/K" },
            { "name": "time_constant", "value": 300.0, "unit": "s" } ] }]);
    let Simulated { campaign, truth } = simulate(&shipped::scenario(&json), 5).unwrap();
    let replay = replay(&campaign, &truth).unwrap();
    let again = simulate(&replay.scenario, 5).unwrap().campaign;
    let pairs = lengths_mm(&again).into_iter().zip(lengths_mm(&campaign));
    let largest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // X grows by 9 µm. While the tracker is carried, 900 s, nothing is logged, and a straight line is beside the
    // sine by 2 K (2π/6000 s)² (900 s)²/8 = 0.2 K, which is 1 µm before the lag.
    assert!(largest < 0.5e-3, "{largest:e}");
}

#[test]
fn what_no_scenario_measures_is_refused() {
    let Simulated { campaign, truth } = simulated("fxyz");
    let refusal = |campaign: &Campaign, truth| replay(campaign, truth).unwrap_err();

    let mut without = campaign.clone();
    without.lengths = None;
    assert!(matches!(refusal(&without, &truth), ReplayError::NoLengths));

    let mut unknown = truth.clone();
    unknown.targets.pop();
    let error = refusal(&campaign, &unknown).to_string();
    assert_eq!(error, "target K was not measured");

    let mut elsewhere = truth.clone();
    elsewhere.targets[0].home_mm.x += 0.3;
    let error = refusal(&campaign, &elsewhere);
    assert!(matches!(error, ReplayError::OtherFrame { off, .. } if (off - 0.1).abs() < 1e-9));
}
