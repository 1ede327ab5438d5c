//! A campaign and the truth about it give the scenario back: simulated again, it measures the same.

use trueaxis_campaign::Campaign;
use trueaxis_simulate::{ReplayError, Scenario, Simulated, Timing, replay, simulate};

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

#[test]
fn the_clock_comes_back() {
    let mut scenario = Scenario::read(shipped::path("rotary-stage")).unwrap();
    scenario.timing = Timing {
        start_s: 3.0,
        per_reading_s: 1.25,
        per_move_s: 7.5,
        per_station_change_s: 600.0,
    };
    let Simulated { campaign, truth } = simulate(&scenario, 1).unwrap();
    let replay = replay(&campaign, &truth).unwrap();
    assert_eq!(replay.scenario.timing, scenario.timing);
    assert_eq!(replay.notices, [""; 0]);
}

/// A pause that an even clock does not have.
#[test]
fn instants_stay_between_the_same_lengths() {
    let Simulated {
        mut campaign,
        mut truth,
    } = simulated("rotary-stage");
    let readings = &mut campaign.lengths.as_mut().unwrap().readings;
    readings[401..].iter_mut().for_each(|r| r.time_s += 500.0);
    let between = |readings: &[trueaxis_campaign::LengthReading]| {
        0.25 * readings[400].time_s + 0.75 * readings[401].time_s
    };
    let shift = ["x", "y", "z"].map(
        |axis| serde_json::json!({ "name": format!("shift_{axis}"), "value": 3.0, "unit": "um" }),
    );
    let time = serde_json::json!({ "name": "time", "value": between(readings), "unit": "s" });
    let [x, y, z] = shift;
    truth.effects = serde_json::from_value(serde_json::json!([
        { "effect": "machine_shift", "subject": {}, "parameters": [time, x, y, z] }
    ]))
    .unwrap();
    let replay = replay(&campaign, &truth).unwrap();
    let again = simulate(&replay.scenario, 5).unwrap().campaign;
    let instant = replay.scenario.effects[0].parameters[0].value;
    let expected = between(&again.lengths.unwrap().readings);
    assert!((instant - expected).abs() < 1e-9, "{instant} {expected}");
    let [notice] = &replay.notices[..] else {
        panic!("{:?}", replay.notices)
    };
    assert!(notice.contains("differs by up to 500 s from that of the campaign"));
}

#[test]
fn what_was_not_measured_is_said() {
    let Simulated {
        mut campaign,
        truth,
    } = simulated("rotary-stage");
    let lengths = campaign.lengths.as_mut().unwrap();
    let missing = lengths.stops.remove(1).readings;
    lengths.readings.drain(missing.clone());
    for stop in &mut lengths.stops[1..] {
        stop.readings = stop.readings.start - missing.len()..stop.readings.end - missing.len();
    }
    let replay = replay(&campaign, &truth).unwrap();
    let said = "replay.json also measures 3 lengths that the campaign does not have";
    assert_eq!(replay.notices, [said]);
}

#[test]
fn another_order_is_refused() {
    let Simulated {
        mut campaign,
        truth,
    } = simulated("rotary-stage");
    campaign.lengths.as_mut().unwrap().stops.swap(3, 4);
    let error = replay(&campaign, &truth).unwrap_err();
    assert!(matches!(error, ReplayError::OtherOrder), "{error}");
}
