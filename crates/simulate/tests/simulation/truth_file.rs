//! `truth.json` has the shape and the units of `calibration.json`.

use serde_json::{Value, json};
use trueaxis_simulate::simulate;

use crate::shipped;

fn truth_json(name: &str) -> Value {
    let truth = simulate(&shipped::scenario(&shipped::json(name)), 3)
        .unwrap()
        .truth;
    serde_json::to_value(&truth).unwrap()
}

#[test]
fn positions_are_degrees_and_errors_micrometres_and_arc_seconds() {
    let truth = truth_json("rotary-stage");
    assert_eq!(truth["format"], "trueaxis-truth");
    assert_eq!(truth["version"], 1);
    assert_eq!(truth["campaign"], "Rotary stage");
    assert_eq!(truth["seed"], 3);
    assert_eq!(
        truth["location_errors"]["X0C"],
        json!({ "value_mm": 0.0142 })
    );
    assert_eq!(
        truth["location_errors"]["A0C"],
        json!({ "value_arcsec": 39.082 })
    );
    let axis = &truth["axes"][0];
    assert_eq!(axis["unit"], "deg");
    let degrees: Vec<f64> = (0..19).map(|i| 20.0 * f64::from(i)).collect();
    assert_eq!(axis["positions"], json!(degrees));
    assert_eq!(axis["direction"], Value::Null);

    // ECC is given at home as 8.1 sin(-35°) + 2.2 sin 80° + 0.7 sin 10° and put to zero there.
    let ecc = |degrees: f64| {
        let sin = |degrees: f64| degrees.to_radians().sin();
        8.1 * sin(degrees - 35.0)
            + 2.2 * sin(2.0 * degrees + 80.0)
            + 0.7 * sin(6.0 * degrees + 10.0)
    };
    let values = &axis["components"]["ECC"]["value_arcsec"];
    assert_eq!(values[0], 0.0);
    let expected = ecc(140.0) - ecc(0.0);
    assert!((values[7].as_f64().unwrap() - expected).abs() < 2e-9);
    assert_eq!(
        axis["components"]["EXC"]["value_um"]
            .as_array()
            .unwrap()
            .len(),
        19
    );
}

#[test]
fn both_directions_have_their_entries() {
    let truth = truth_json("five-axis");
    let axis = &truth["axes"][1];
    assert_eq!(axis["name"], "Y");
    assert_eq!(axis["positions"][11], 0.0);
    assert_eq!(axis["direction"][10], 1);
    assert_eq!(axis["direction"][11], -1);
    let positioning = &axis["components"]["EYY"]["value_um"];
    assert_eq!([&positioning[0], &positioning[11]], [-1.8, 1.8]);
}

#[test]
fn the_file_is_written_whole_and_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("truth.json");
    std::fs::write(&path, "old").unwrap();
    let truth = simulate(&shipped::scenario(&shipped::json("fxyz")), 3)
        .unwrap()
        .truth;
    truth.write(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(
        serde_json::from_str::<Value>(&text).unwrap(),
        truth_json("fxyz")
    );
    let places = [
        "\"format\"",
        "\"stations\"",
        "\"EXX\"",
        "\"EYX\"",
        "\"EAX\"",
        "\"C0Y\"",
    ]
    .map(|name| text.find(name).unwrap());
    assert!(places.is_sorted());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let nowhere = folder.path().join("missing").join("truth.json");
    assert!(truth.write(&nowhere).is_err());
}
