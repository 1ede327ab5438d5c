//! Scenarios that are wrong: each is refused with the place, the reason and how to correct it.

use std::error::Error as _;

use serde_json::{Value, json};
use trueaxis_simulate::{Error, Problem, Scenario};

use crate::shipped;

/// The whole chain of messages, as a program prints it.
pub(crate) fn chain(error: &Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text = format!("{text}: {error}");
        source = error.source();
    }
    text
}

/// A shipped scenario with other values at some JSON pointers.
fn altered(name: &str, changes: &[(&str, Value)]) -> Value {
    let mut json = shipped::json(name);
    for (pointer, value) in changes {
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        match json.pointer_mut(parent).unwrap() {
            Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
            object => object[key] = value.clone(),
        }
    }
    json
}

/// What is said about it, without the place (the text has one line).
pub(crate) fn refused(name: &str, changes: &[(&str, Value)]) -> String {
    let text = altered(name, changes).to_string();
    let message = chain(&Scenario::from_json(&text).unwrap_err());
    let without_line = message.strip_prefix("line 1").unwrap();
    let reason = without_line.strip_prefix(", field ");
    reason
        .or(without_line.strip_prefix(": "))
        .unwrap()
        .to_owned()
}

#[test]
fn the_file_and_the_line_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scenario.json");
    let text = std::fs::read_to_string(shipped::path("fxyz")).unwrap();
    let cases = [
        (
            r#""repeats""#,
            r#""repaets""#,
            "unknown field `repaets`",
            "did you mean `repeats`?",
        ),
        (
            r#""name": "S3""#,
            r#""name": "S2""#,
            "field stations[2].name: station `S2` has this name already",
            "in stations[1].name",
        ),
        (
            r#""axis": "Y""#,
            r#""axis": "V""#,
            "field runs[1].axis: unknown axis `V`",
            "known: X, Y, Z",
        ),
        (
            "1283.0657",
            r#""long""#,
            "stations[1].dead_path_mm: invalid type",
            "expected a number with a decimal point",
        ),
        (
            r#""EYX": ["#,
            r#""EXX": ["#,
            "errors.X.components",
            "`EXX` stands here twice",
        ),
    ];
    for (old, new, what, hint) in cases {
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let message = chain(&Scenario::read(&path).unwrap_err());
        let line = 1 + text.lines().position(|line| line.contains(old)).unwrap();
        let place = format!("{} line {line}, field ", path.display());
        assert!(message.starts_with(&place), "{message}");
        assert!(message.contains(what), "{message}");
        assert!(message.contains(hint), "{message}");
    }
}

#[test]
fn a_missing_file_is_named() {
    let missing = Scenario::read("no/such/scenario.json").unwrap_err();
    assert!(matches!(*missing.problem, Problem::Read(_)));
    assert_eq!(
        missing.to_string(),
        "no/such/scenario.json: the file cannot be read"
    );
}

#[test]
fn each_wrong_field_is_named_with_the_reason() {
    let c0x = json!({ "C0X": { "value_arcsec": 3 } });
    let a0y = json!({ "A0Y": { "value_arcsec": 3 } });
    let cases: Vec<(&str, &str, Value, &str)> = vec![
        (
            "fxyz",
            "/format",
            json!("trueaxis-campaign"),
            "format: this is a trueaxis campaign, not a scenario; give the path of the scenario.json",
        ),
        ("fxyz", "/version", json!(2), "version: found 2; expected 1"),
        ("fxyz", "/repeats", json!(0), "repeats: expected at least 1"),
        (
            "fxyz",
            "/machine/axes/0/direction",
            json!([1, 1, 0]),
            "machine.axes[0].direction: axis X: direction [1, 1, 0] has length",
        ),
        (
            "fxyz",
            "/machine/kinematics/tool",
            json!(["X", "Y"]),
            "machine.kinematics: axis Z appears in no",
        ),
        (
            "fxyz",
            "/machine/axes/0/position_mm",
            json!([0, 0, 0]),
            "machine.axes[0].position_mm: axis X is linear and has a position; expected",
        ),
        (
            "fxyz",
            "/targets/1/carried_by",
            json!("ZZ"),
            "targets[1].carried_by: unknown axis `ZZ`; did you mean `Z`? known: X, Y, Z",
        ),
        (
            "fxyz",
            "/errors/X/components/EXY",
            json!([]),
            "errors.X.components.EXY: unknown component error `EXY`; did you mean `EXX`? known: EXX, \
             EYX, EZX, EAX, EBX, ECX",
        ),
        (
            "fxyz",
            "/errors/X/components/EXX/1/period_mm",
            json!(0),
            "errors.X.components.EXX[1].period_mm: expected more than zero, found 0",
        ),
        (
            "fxyz",
            "/errors/X/components/EXX/1/kind",
            json!("sinus"),
            "errors.X.components.EXX[1].kind: unknown value `sinus`; did you mean `sine`? known: \
             polynomial, sine, table",
        ),
        (
            "fxyz",
            "/errors/X/lost_motion_arcsec",
            json!(1),
            "errors.X.lost_motion_arcsec: expected `lost_motion_um` for a linear axis",
        ),
        (
            "fxyz",
            "/errors/Y/location_errors/C0Y",
            json!({ "value_mm": 1 }),
            "errors.Y.location_errors.C0Y: expected `value_arcsec` alone for a tilt",
        ),
        (
            "fxyz",
            "/errors/X/location_errors",
            c0x,
            "errors.X.location_errors.C0X: C0X = 3 arcsec must be zero, because the reference \
             frame takes its first direction from the average line of X",
        ),
        (
            "fxyz",
            "/errors/Y/location_errors",
            a0y,
            "errors.Y.location_errors.A0Y: A0Y = 3 arcsec must be zero, because the average lines \
             of X and Y lie in a plane of the reference frame, so Y can only tilt about the normal",
        ),
        (
            "rotary-stage",
            "/errors/C/location_errors/Z0C",
            json!({ "value_mm": 0.01 }),
            "errors.C.location_errors.Z0C: Z0C = 0.01 mm must be zero, because without a linear",
        ),
        (
            "fxyz",
            "/runs/0/sweep/step",
            json!(30),
            "runs[0].sweep: expected whole steps from start to stop, but 30 does not divide",
        ),
        (
            "fxyz",
            "/runs/0/sweep/stop",
            json!(460),
            "runs[0].sweep: position 460 of axis X is outside its travel [0, 440]",
        ),
        (
            "fxyz",
            "/runs/0/positions",
            json!([0, 10]),
            "runs[0]: expected either `positions` or `sweep`",
        ),
        (
            "fxyz",
            "/runs/0/parked",
            json!({ "Y": -1 }),
            "runs[0].parked.Y: position -1 of axis Y is outside its travel [0, 400]",
        ),
        (
            "fxyz",
            "/runs/0/directions",
            json!([1, 1]),
            "runs[0].directions: expected [1], [-1], [1, -1] or [-1, 1]",
        ),
        (
            "fxyz",
            "/runs/2/axis",
            json!("Y"),
            "errors.Z: axis Z has errors, but no run moves it",
        ),
        (
            "rotary-stage",
            "/runs/0/sweep/step",
            json!(360),
            "errors.C: the 2 commanded positions of axis C cannot separate its location errors",
        ),
        (
            "five-axis",
            "/runs/1/directions",
            json!([1]),
            "errors.Y: lost motion of axis Y is the difference between both directions, but run y",
        ),
        (
            "five-axis",
            "/runs/3/targets",
            json!(["U", "P"]),
            "runs[3].targets[1]: axis A does not move target P, which Z carries",
        ),
        (
            "fxyz",
            "/noise",
            json!({ "length_sigma_um": -1 }),
            "noise.length_sigma_um: expected zero or more, found -1",
        ),
        (
            "fxyz",
            "/noise",
            json!({ "exact": true }),
            "noise.exact: lengths are exact only without noise, but length_sigma_um = 0.269",
        ),
        (
            "fxyz",
            "/timing",
            json!({ "per_move_s": -4 }),
            "timing.per_move_s: expected zero or more, found -4",
        ),
    ];
    for (name, pointer, value, expected) in cases {
        let message = refused(name, &[(pointer, value)]);
        assert!(message.starts_with(expected), "{pointer}: {message}");
    }
}

#[test]
fn a_target_that_no_run_measures_is_refused() {
    let two = json!(["P", "K"]);
    let changes = ["/runs/0/targets", "/runs/1/targets", "/runs/2/targets"];
    let message = refused("fxyz", &changes.map(|pointer| (pointer, two.clone())));
    assert!(message.starts_with("targets[1]: no run measures target Q"));
}

/// Mounting errors that move the frame are refused, and those offered instead pass.
#[test]
fn offered_mounting_errors_pass() {
    let shifted = json!([0.11, 0.0, 0.0]);
    let cases = [
        ("fxyz", "of P, Q, K have the mean ["),
        ("rotary-stage", "of P, Q, K have the mean ["),
        ("five-axis", "of P, Q, K have the mean ["),
    ];
    for (name, expected) in cases {
        let message = refused(name, &[("/targets/0/mounting_error_mm", shifted.clone())]);
        assert!(message.contains(expected), "{message}");
        assert!(Scenario::from_json(&corrected(name, &message).to_string()).is_ok());
    }

    let turned = [
        ("/targets/0/mounting_error_mm", json!([0.02, 0.0, 0.0])),
        ("/targets/1/mounting_error_mm", json!([-0.01, 0.0, 0.0])),
        ("/targets/2/mounting_error_mm", json!([-0.01, 0.0, 0.0])),
    ];
    let message = refused("rotary-stage", &turned);
    assert!(message.contains("contain the rotation"), "{message}");
    assert!(Scenario::from_json(&corrected("rotary-stage", &message).to_string()).is_ok());
    // Two linear runs leave no rotation to the targets.
    assert!(Scenario::from_json(&altered("fxyz", &turned).to_string()).is_ok());
}

/// The scenario with the mounting errors that the message offers.
fn corrected(name: &str, message: &str) -> Value {
    let (_, offer) = message.split_once("these would pass: ").unwrap();
    let values = offer.split(['[', ']']).skip(1).step_by(2);
    let mut json = shipped::json(name);
    for (i, value) in values.enumerate() {
        let value: Value = serde_json::from_str(&format!("[{value}]")).unwrap();
        json["targets"][i]["mounting_error_mm"] = value;
    }
    json
}
