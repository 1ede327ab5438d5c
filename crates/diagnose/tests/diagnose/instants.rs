//! When something happened, and how well the data tell it.

use trueaxis_campaign::Campaign;
use trueaxis_diagnose::{Settings, diagnose};
use trueaxis_simulate::{Scenario, simulate};

const FIVE_AXIS: &str = include_str!("../../../../campaigns/five-axis/scenario.json");

/// Runs of X, which moves the tool, and C, which moves the table, from one side, of a machine without errors.
fn simulated(effects: serde_json::Value) -> Campaign {
    let mut scenario: serde_json::Value = serde_json::from_str(FIVE_AXIS).unwrap();
    scenario["effects"] = effects;
    scenario["errors"] = serde_json::json!({});
    for target in scenario["targets"].as_array_mut().unwrap() {
        target.as_object_mut().unwrap().remove("mounting_error_mm");
    }
    let runs = scenario["runs"].as_array_mut().unwrap();
    runs.retain(|run| run["axis"] == "X" || run["axis"] == "C");
    for run in runs {
        run["directions"] = serde_json::json!([1]);
    }
    let scenario = Scenario::from_json(&scenario.to_string()).unwrap();
    simulate(&scenario, 3).unwrap().campaign
}

/// From the start of the last stop with target V at S2 to the first at S3, s.
fn gap_s() -> [f64; 2] {
    let campaign = simulated(serde_json::json!([]));
    let lengths = campaign.lengths.as_ref().unwrap();
    let starts_s = |station: usize| {
        let stops = lengths.stops.iter();
        let readings = stops.filter(move |stop| stop.station == station);
        let readings = readings.map(|stop| &lengths.readings[stop.readings.clone()]);
        let is_v = |target: usize| campaign.targets[target].name == "V";
        let with_v = readings.filter(move |own| own.iter().any(|r| is_v(r.target)));
        with_v.map(|own| own[0].time_s).collect::<Vec<f64>>()
    };
    [*starts_s(1).last().unwrap(), starts_s(2)[0]]
}

/// The time of the slip that is found, and its u, s.
fn found_s([x, y, z]: [f64; 3], slip_s: f64) -> [f64; 2] {
    let slip = serde_json::json!([{ "effect": "target_slip", "subject": { "target": "V" }, "parameters": [
        { "name": "slip_x", "value": x, "unit": "um" }, { "name": "slip_y", "value": y, "unit": "um" },
        { "name": "slip_z", "value": z, "unit": "um" }, { "name": "time", "value": slip_s, "unit": "s" } ] }]);
    let diagnosis = diagnose(&simulated(slip), &Settings::default()).unwrap();
    let cause = &diagnosis.causes[0];
    assert_eq!(cause.effect.effect.id, "target_slip");
    let time = cause.parameters.last().unwrap();
    [time.value, time.u]
}

/// A target of the table slips while the tracker moves from S2 to S3 and measures the tool: anywhere in that time, of which the
/// stops with the tool say nothing. A uniform density over it has a standard deviation of its length over √12. If S3 sees
/// next to nothing of the slip at its first stop, the slip may have come behind it as well, but no less before it: for each
/// second of the gap the data speak as for each second of the stop.
#[test]
fn a_slip_between_two_occupations_is_as_uncertain_as_the_gap_is_long() {
    let [before_s, after_s] = gap_s();
    let gap_s = after_s - before_s;
    let slip_s = before_s + 0.1 * gap_s;
    let [time_s, u_s] = found_s([9.0, 12.0, 2.0], slip_s);
    assert!((before_s..after_s).contains(&time_s));
    assert!((u_s * 12_f64.sqrt() / gap_s - 1.0).abs() < 0.01, "{u_s}");
    let [time_s, u_s] = found_s([12.0, -8.0, 9.0], slip_s);
    assert!(
        (time_s - slip_s).abs() < 4.0 * u_s && u_s < gap_s,
        "{time_s} ± {u_s}"
    );
}
