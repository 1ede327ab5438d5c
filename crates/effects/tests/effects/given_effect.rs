//! Effects by name: there and back, and what is refused.

use serde_json::{Value, json};
use trueaxis_effects::{Circumstances, GivenEffect};

use crate::scene::{every_effect, scene};

fn given(json: &Value) -> GivenEffect {
    serde_json::from_str(&json.to_string()).unwrap()
}

fn slip() -> Value {
    json!({
        "effect": "target_slip",
        "subject": { "station": null, "target": "V", "axis": null, "other_axis": null, "component": null },
        "parameters": [
            { "name": "time", "value": 40.0, "u": 2.0, "unit": "s" },
            { "name": "slip_z", "value": 3.0, "unit": "um" },
            { "name": "slip_x", "value": 1.0, "u": 0.1, "unit": "um" },
            { "name": "slip_y", "value": 2.0, "unit": "um" }
        ]
    })
}

/// The whole catalogue on all its subjects: to names, to text, and back.
#[test]
fn every_effect_comes_back_from_its_text() {
    let scene = scene();
    for resolved in every_effect(&scene) {
        let written = resolved.to_given(&scene);
        let text = trueaxis_files::to_json(&written).unwrap();
        let read: GivenEffect = serde_json::from_str(&text).unwrap();
        assert_eq!(read, written, "{text}");
        let back = read.resolve(&scene).unwrap();
        assert_eq!(back.effect.id, resolved.effect.id);
        assert_eq!(back.subject, resolved.subject, "{text}");
        assert_eq!(back.parameters, resolved.parameters, "{text}");
        // Degrees and back again round once each.
        let off = (back.shape - resolved.shape).abs();
        assert!(off <= 2.0 * f64::EPSILON * resolved.shape, "{text}");
    }
}

#[test]
fn parameters_are_sorted_and_the_rest_may_be_left_out() {
    let scene = scene();
    let resolved = given(&slip()).resolve(&scene).unwrap();
    assert_eq!(resolved.parameters, [1.0, 2.0, 3.0]);
    assert_eq!(resolved.shape.to_bits(), 40.0_f64.to_bits());
    assert_eq!(resolved.subject.target, Some(1));

    let short = json!({ "effect": "length_scale", "parameters": [ { "name": "scale", "value": 1, "unit": "ppm" } ] });
    let resolved = given(&short).resolve(&scene).unwrap();
    let at = Circumstances {
        distance_mm: 1000.0,
        ..Circumstances::new(&scene.machine)
    };
    assert!((resolved.displaced(&at).length_mm - 1e-3).abs() < 1e-18);
}

#[test]
fn uncertainties_are_kept() {
    let mut json = slip();
    let written = serde_json::to_value(given(&json)).unwrap();
    assert_eq!(written, json);
    // One that is not there is not written.
    json["parameters"][1]["u"] = Value::Null;
    let written = serde_json::to_value(given(&json)).unwrap();
    assert_eq!(written, slip());
}

#[test]
fn a_period_of_a_rotary_axis_is_in_degrees() {
    let scene = scene();
    let cyclic = |axis: &str, component: &str, unit: &str| {
        json!({ "effect": "cyclic_error", "subject": { "axis": axis, "component": component },
            "parameters": [ { "name": "sine", "value": 1, "unit": "um" },
                            { "name": "cosine", "value": 0, "unit": "um" },
                            { "name": "period", "value": 90, "unit": unit } ] })
    };
    let shape = |json: &Value| given(json).resolve(&scene).map(|resolved| resolved.shape);
    assert_eq!(shape(&cyclic("C", "EXC", "deg")), Ok(90.0_f64.to_radians()));
    assert_eq!(shape(&cyclic("X", "EYX", "mm")), Ok(90.0));
    let refused = shape(&cyclic("C", "EXC", "mm")).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "field parameters[2].unit: `period` is in `deg`, found `mm`"
    );
}

#[test]
fn what_does_not_fit_is_refused_with_its_field() {
    let scene = scene();
    let altered = |pointer: &str, value: Value| {
        let mut json = slip();
        *json.pointer_mut(pointer).unwrap() = value;
        json
    };
    let without = |index: usize| {
        let mut json = slip();
        json["parameters"].as_array_mut().unwrap().remove(index);
        json
    };
    let warm_up = json!({ "effect": "warm_up", "parameters": [
        { "name": "growth_x", "value": 1, "unit": "um" },
        { "name": "growth_y", "value": 1, "unit": "um" },
        { "name": "growth_z", "value": 1, "unit": "um" },
        { "name": "time_constant", "value": 0, "unit": "s" } ] });
    let worm = json!({ "effect": "worm_gear", "subject": { "axis": "C" }, "parameters": [
        { "name": "sine", "value": 1, "unit": "arcsec" },
        { "name": "cosine", "value": 1, "unit": "arcsec" },
        { "name": "waves", "value": 2.5, "unit": "1" } ] });
    let cases = [
        (
            altered("/effect", json!("target_slips")),
            "effect: unknown effect `target_slips`; did you mean `target_slip`? known: dead_path_drift, ",
            " in all)",
        ),
        (
            altered("/effect", json!("Machine_drfit")),
            "effect: unknown effect `Machine_drfit`; did you mean `machine_drift`? known: dead_path_drift, ",
            " in all)",
        ),
        (
            altered("/effect", json!("x")),
            "effect: unknown effect `x`; known: dead_path_drift, ",
            " in all)",
        ),
        (
            altered("/subject/target", json!("v")),
            "subject.target: unknown target `v`; did you mean `V`? known: P, V",
            "",
        ),
        (
            altered("/subject/axis", json!("W")),
            "subject.axis: unknown axis `W`; known: X, Y, Z, A, C",
            "",
        ),
        (
            altered("/subject/target", Value::Null),
            "subject: target_slip cannot act on (all alike); possible here: (target P), (target V)",
            "",
        ),
        (
            altered("/subject/component", json!("EXX")),
            "subject: target_slip cannot act on (target V, component EXX); possible here: ",
            "",
        ),
        (
            altered("/subject/component", json!("EXW")),
            "subject.component: unknown component error `EXW`; did you mean `EXX`? known: EXX, ",
            "",
        ),
        (
            altered("/parameters/1/name", json!("slip_w")),
            "parameters[1].name: unknown parameter `slip_w`; did you mean `slip_x`? known: slip_x, \
             slip_y, slip_z, time",
            "",
        ),
        (
            altered("/parameters/1/name", json!("slip_x")),
            "parameters[2].name: there is another parameter named `slip_x`",
            "",
        ),
        (
            altered("/parameters/1/unit", json!("mm")),
            "parameters[1].unit: `slip_z` is in `um`, found `mm`",
            "",
        ),
        (
            altered("/parameters/2/u", json!(-0.1)),
            "parameters[2].u: expected a standard uncertainty, zero or more, found -0.1",
            "",
        ),
        (
            without(1),
            "parameters: target_slip also needs `slip_z` in um",
            "",
        ),
        (
            without(0),
            "parameters: target_slip also needs `time` in s",
            "",
        ),
        (
            warm_up,
            "parameters[3].value: expected more than zero, found 0",
            "",
        ),
        (
            worm,
            "parameters[2].value: expected a whole number from 1, found 2.5",
            "",
        ),
    ];
    for (json, start, end) in cases {
        let error = given(&json).resolve(&scene).unwrap_err();
        let message = error.to_string();
        let reason = message.strip_prefix("field ").unwrap();
        assert!(reason.starts_with(start), "{message}");
        assert!(reason.ends_with(end), "{message}");
        assert!(
            start.starts_with(error.place.field_path().unwrap()),
            "{message}"
        );
    }
    let mut infinite = given(&slip());
    infinite.parameters[3].value = f64::INFINITY;
    assert_eq!(
        infinite.resolve(&scene).unwrap_err().to_string(),
        "field parameters[3].value: expected a finite number, found inf"
    );
}

#[test]
fn unknown_fields_are_refused() {
    for pointer in ["", "/subject", "/parameters/0"] {
        let mut json = slip();
        json.pointer_mut(pointer).unwrap()["rank"] = json!(1);
        let read: Result<GivenEffect, _> = serde_json::from_value(json);
        let message = read.unwrap_err().to_string();
        assert!(message.starts_with("unknown field `rank`"), "{message}");
    }
}
