//! Effects in scenarios: what stays the same, what is refused, what the truth says.

use std::path::Path;

use serde_json::{Value, json};
use trueaxis_effects::{
    Medium, Parameter, ResolvedEffect, Scene, SceneTarget, SceneTemperature, Shape,
};
use trueaxis_effects::{catalogue, shape_parameter};
use trueaxis_simulate::{Scenario, Simulated, simulate};

use crate::refusals::{chain, refused};
use crate::shipped;

fn shift(time_s: f64) -> Value {
    json!({ "effect": "machine_shift", "parameters": [
        { "name": "time", "value": time_s, "unit": "s" },
        { "name": "shift_z", "value": 2.0, "unit": "um" },
        { "name": "shift_x", "value": 3.0, "u": 0.2, "unit": "um" },
        { "name": "shift_y", "value": -1.0, "unit": "um" } ] })
}

fn with_effects(name: &str, effects: Value) -> Value {
    let mut json = shipped::json(name);
    json["effects"] = effects;
    json
}

fn simulated(json: &Value) -> Simulated {
    simulate(&shipped::scenario(json), 1).unwrap()
}

fn lengths_mm(json: &Value) -> Vec<f64> {
    let lengths = simulated(json).campaign.lengths.unwrap();
    lengths.readings.iter().map(|r| r.length_mm).collect()
}

/// The line of a shipped campaign for editors.
const SCHEMA: &str = "  \"$schema\": \"../campaign.schema.json\",\n";

/// The shipped campaigns, byte for byte but for the schema that they name: seed 1.
#[test]
fn without_effects_the_shipped_files_are_written() {
    for name in shipped::NAMES {
        let folder = tempfile::tempdir().unwrap();
        let Simulated { campaign, truth } = simulated(&shipped::json(name));
        trueaxis_campaign::write(&campaign, folder.path()).unwrap();
        truth.write(folder.path().join("truth.json")).unwrap();
        for file in ["campaign.json", "lengths.csv", "truth.json"] {
            let shipped = shipped::path(name).with_file_name(file);
            let shipped = std::fs::read_to_string(shipped).unwrap();
            let shipped = shipped.replace(SCHEMA, "");
            let written = std::fs::read_to_string(folder.path().join(file)).unwrap();
            assert!(written == shipped, "{name}/{file} differs");
        }
    }
}

/// Beyond the end of the campaign, or of the occupation of its station.
#[test]
fn effects_that_never_act_are_said() {
    let jump = |time_s: f64| {
        json!({ "effect": "station_jump", "subject": { "station": "S1" }, "parameters": [
            { "name": "jump_x", "value": 5.0, "unit": "um" }, { "name": "jump_y", "value": 0.0, "unit": "um" },
            { "name": "jump_z", "value": 0.0, "unit": "um" }, { "name": "time", "value": time_s, "unit": "s" } ] })
    };
    let readings = simulated(&shipped::json("fxyz"))
        .campaign
        .lengths
        .unwrap()
        .readings;
    let last_s = readings.last().unwrap().time_s;
    let effects = json!([
        shift(1e9),
        shift(0.5 * last_s),
        jump(0.1 * last_s),
        jump(0.5 * last_s)
    ]);
    let found = simulated(&with_effects("fxyz", effects)).campaign;
    assert_eq!(found.notices.len(), 2, "{:?}", found.notices);
    assert!(found.notices[0].starts_with("effects[0], `machine_shift`, changes no length"));
    assert!(found.notices[1].starts_with("effects[3], `station_jump`, changes no length"));
}

/// The stations, targets and axes of the shipped five-axis machine, all of which move.
fn five_axis_scene() -> Scene {
    let campaign = simulated(&shipped::json("five-axis")).campaign;
    let targets = campaign.targets.into_iter().map(|target| SceneTarget {
        name: target.name,
        carrier: target.carrier,
    });
    Scene {
        stations: campaign.stations.into_iter().map(|s| s.name).collect(),
        targets: targets.collect(),
        moving: (0..campaign.machine.axes().len()).collect(),
        temperatures: Vec::new(),
        machine: campaign.machine,
    }
}

/// The whole catalogue at once, each effect on its last subject, of no size.
#[test]
fn effects_of_no_size_change_no_length() {
    let scene = five_axis_scene();
    let effects = catalogue().iter().filter_map(|&effect| {
        let subject = effect.subjects(&scene).pop()?;
        let resolved = ResolvedEffect {
            effect,
            parameters: vec![0.0; effect.parameters(&scene, &subject).len()],
            subject,
            shape: match effect.shape {
                Shape::Fixed => 0.0,
                Shape::Instant | Shape::TimeConstant | Shape::SettlingTime | Shape::Lag => 600.0,
                Shape::Period => 2.0,
                Shape::Waves(_) => 3.0,
            },
        };
        Some(serde_json::to_value(resolved.to_given(&scene)).unwrap())
    });
    let json = with_effects("five-axis", effects.collect());
    let plain = shipped::json("five-axis");
    assert!(json["effects"].as_array().unwrap().len() >= 17);
    assert_eq!(lengths_mm(&json), lengths_mm(&plain));
}

#[test]
fn an_instant_leaves_all_readings_up_to_it_as_they_were() {
    let plain = simulated(&shipped::json("fxyz")).campaign.lengths.unwrap();
    // On the time of a reading: that one is still before the shift.
    let last_s = plain.readings[1000].time_s;
    let json = with_effects("fxyz", json!([shift(last_s)]));
    let shifted = lengths_mm(&json);
    for (i, (before, after)) in plain.readings.iter().zip(shifted).enumerate() {
        let change_mm = after - before.length_mm;
        assert_eq!(change_mm.abs() > 0.0, i > 1000, "reading {i}: {change_mm}");
        // |D| = √14 µm; lengths are rounded to 1e-7 mm.
        assert!(change_mm.abs() < 3.742e-3 + 1e-7);
    }
}

#[test]
fn effects_add_up() {
    let drift = json!({ "effect": "refraction_drift",
        "parameters": [ { "name": "scale_drift", "value": 2.0, "unit": "ppm" } ] });
    let mut changes = [
        json!([]),
        json!([shift(2000.0)]),
        json!([drift]),
        json!([shift(2000.0), drift]),
    ]
    .map(|effects| {
        let mut json = with_effects("rotary-stage", effects);
        shipped::make_exact(&mut json);
        lengths_mm(&json)
    });
    let plain = changes[0].clone();
    for lengths in &mut changes {
        for (length, plain) in lengths.iter_mut().zip(&plain) {
            *length -= plain;
        }
    }
    let [_, shifted, drifted, both] = &changes;
    for ((shifted, drifted), both) in shifted.iter().zip(drifted).zip(both) {
        // Both are functions of the undisturbed points, so only f64 is between them.
        assert!((both - shifted - drifted).abs() < 1e-12);
    }
}

#[test]
fn the_truth_names_the_effects() {
    let json = with_effects("fxyz", json!([shift(2000.0)]));
    let truth = serde_json::to_value(&simulated(&json).truth).unwrap();
    let shift = &truth["effects"][0];
    assert_eq!(shift["effect"], "machine_shift");
    assert_eq!(shift["parameters"][2]["u"], 0.2);
    let mut without = truth.clone();
    without.as_object_mut().unwrap().remove("effects");
    let plain = simulated(&shipped::json("fxyz")).truth;
    assert_eq!(without, serde_json::to_value(&plain).unwrap());
}

#[test]
fn wrong_effects_are_refused_with_their_field() {
    let altered = |pointer: &str, value: Value| {
        let mut effect = shift(2000.0);
        *effect.pointer_mut(pointer).unwrap() = value;
        json!([shift(1000.0), effect])
    };
    let cases = [
        (
            altered("/effect", json!("machine_shfit")),
            "effects[1].effect: unknown effect `machine_shfit`",
        ),
        (
            altered("/parameters/0/unit", json!("ms")),
            "effects[1].parameters[0].unit: `time` is in `s`, found `ms`",
        ),
        (
            altered("/parameters/1/name", json!("shift_w")),
            "effects[1].parameters[1].name: unknown parameter `shift_w`; did you mean \
             `shift_x`? known: shift_x, shift_y, shift_z, time",
        ),
        (
            altered(
                "/parameters/1",
                json!({ "name": "shift_z", "value": 2.0, "units": "um" }),
            ),
            "effects[1].parameters[1].units: unknown field `units`",
        ),
        (
            json!([{ "effect": "station_jump", "subject": { "station": "S9" }, "parameters": [] }]),
            "effects[0].subject.station: unknown station `S9`; did you mean `S1`? \
             known: S1, S2, S3, S4",
        ),
        (
            json!([{ "effect": "backlash", "subject": { "axis": "X", "target": "P" },
                     "parameters": [ { "name": "lost_motion", "value": 1, "unit": "um" } ] }]),
            "effects[0].subject: backlash cannot act on (target P, axis X); \
             possible here: (axis X), (axis Y), (axis Z)",
        ),
    ];
    for (effects, expected) in cases {
        let message = refused("fxyz", &[("/effects", effects)]);
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn the_line_of_a_wrong_effect_is_named() {
    let text = serde_json::to_string_pretty(&with_effects("fxyz", json!([shift(2000.0)]))).unwrap();
    let wrong = text.replace("\"shift_y\"", "\"shift_x\"");
    let line = 1 + wrong
        .rfind("\"shift_x\"")
        .map(|at| wrong[..at].matches('\n').count())
        .unwrap();
    let message = chain(&Scenario::from_json(&wrong).unwrap_err());
    let expected = format!(
        "line {line}, field effects[0].parameters[3].name: there is another parameter named `shift_x`"
    );
    assert_eq!(message, expected);
}

fn documentation() -> String {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenario.md");
    std::fs::read_to_string(docs).unwrap()
}

/// The documented effects work in the documented scenario.
#[test]
fn the_documented_effects_can_be_simulated() {
    let docs = documentation();
    let blocks: Vec<&str> = docs.split("```json").skip(1).collect();
    let text = |block: usize| blocks[block].split("```").next().unwrap().to_owned();
    let mut json: Value = serde_json::from_str(&text(0)).unwrap();
    let plain = lengths_mm(&json);
    let effects: Value = serde_json::from_str(&format!("{{ {} }}", text(1))).unwrap();
    json["effects"] = effects["effects"].clone();
    let moved = lengths_mm(&json);
    let changed = plain
        .iter()
        .zip(&moved)
        .filter(|(a, b)| a.total_cmp(b).is_ne())
        .count();
    assert!(changed > plain.len() / 4 && changed < plain.len());
}

/// Every effect has one row in the table, which holds the names and units of all its parameters.
#[test]
fn the_documented_table_is_that_of_the_catalogue() {
    let docs = documentation();
    let temperature = |column: &str, medium| SceneTemperature {
        column: column.to_owned(),
        medium,
    };
    let scene = Scene {
        temperatures: vec![
            temperature("machine_temp_c", Medium::Machine),
            temperature("air_temp_c", Medium::Air),
        ],
        ..five_axis_scene()
    };
    for effect in catalogue() {
        let start = format!("| `{}` |", effect.id);
        let rows: Vec<&str> = docs.lines().filter(|l| l.starts_with(&start)).collect();
        assert_eq!(rows.len(), 1, "{}", effect.id);
        for subject in effect.subjects(&scene) {
            let mut parameters = effect.parameters(&scene, &subject);
            parameters.extend(shape_parameter(effect, &scene, &subject));
            for Parameter { name, unit, .. } in parameters {
                let name = match name.strip_prefix("rate_") {
                    Some(station) if scene.stations.iter().any(|s| s == station) => "rate_",
                    _ => &name,
                };
                assert!(
                    rows[0].contains(&format!("`{name}`")),
                    "{name}: {}",
                    rows[0]
                );
                let units = rows[0].split([' ', ',', ';', ':', '(', ')']);
                assert!(
                    units.clone().any(|word| word == unit),
                    "{unit}: {}",
                    rows[0]
                );
            }
        }
    }
}
