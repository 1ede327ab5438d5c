//! Scenarios that are written can be read: nothing is lost.

use serde_json::json;
use trueaxis_simulate::Scenario;

use crate::shipped;

#[test]
fn shipped_scenarios_come_back() {
    for name in shipped::NAMES {
        let scenario = Scenario::read(shipped::path(name)).unwrap();
        let text = trueaxis_files::to_json(&scenario).unwrap();
        assert_eq!(Scenario::from_json(&text).unwrap(), scenario, "{name}");
        // What is optional and not there is left out.
        assert!(!text.contains("null"), "{text}");
    }
}

/// Every field that the format has, each with a value that is not its default.
#[test]
fn every_field_comes_back() {
    let mut json = shipped::json("five-axis");
    json["gauge"] = json!("none");
    json["noise"] =
        json!({ "length_sigma_um": 0.1, "length_sigma_ppm": 0.2, "repeatability_um": 0.3 });
    json["timing"] = json!({
        "start_s": 1.5, "per_reading_s": 2.5, "per_move_s": 0.1, "per_station_change_s": 1000.0
    });
    json["stations"][0]["declare_approx"] = json!(true);
    json["stations"][0]["dead_path_sigma_mm"] = json!(0.01);
    json["targets"][0]["reflector"] = json!("R1");
    json["targets"][0]["position_sigma_mm"] = json!(0.5);
    json["reflectors"] = json!([{ "name": "R1", "constant_um": 1.0 / 3.0 }]);
    json["systematic"] =
        json!({ "reflector_sigma_um": 2.0, "scale_sigma_ppm": 0.1, "position_sigma_mm": 0.0 });
    json["known_lengths"] = json!([{ "targets": ["P", "Q"], "sigma_um": 0.3 }]);
    json["temperatures"] = json!([
        { "column": "machine_temp_x_c", "sigma_k": 0.01, "course": [
            { "kind": "table", "times_s": [0.0, 60.0], "values_c": [20.0, 21.0] },
            { "kind": "exponential", "change_k": 3.0, "time_constant_s": 600.0, "start_s": 10.0 },
            { "kind": "sine", "amplitude_k": 1.0, "period_s": 86400.0, "phase_deg": 90.0 } ] }
    ]);
    json["machine"]["axes"][0]["expansion_ppm_per_k"] = json!(11.5);
    json["machine"]["axes"][0]["temperature_column"] = json!("machine_temp_x_c");
    json["machine"]["axes"][0]["temperature_sigma_k"] = json!(0.2);
    json["runs"][0]["parked"] = json!({ "Y": 0.1 });
    json["runs"][0]["targets"] = json!(["K", "P", "Q"]);
    json["runs"][0]["directions"] = json!([-1, 1]);
    json["errors"]["X"]["components"]["EXX"] = json!([
        { "kind": "table", "positions": [0.0, 0.3, 400.0], "values": [0.0, 0.1, 1.0 / 3.0] }
    ]);
    json["effects"] = json!([
        { "effect": "stage_bending", "subject": { "axis": "C", "target": "W" }, "parameters": [
            { "name": "bending_x", "value": 1.0 / 3.0, "u": 0.1, "unit": "um/rad2" },
            { "name": "bending_y", "value": -2.0, "unit": "um/rad2" },
            { "name": "bending_z", "value": 0.0, "unit": "um/rad2" } ] }
    ]);
    let scenario = shipped::scenario(&json);
    let text = trueaxis_files::to_json(&scenario).unwrap();
    assert_eq!(Scenario::from_json(&text).unwrap(), scenario);
}
