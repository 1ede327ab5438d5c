//! Tables that move one axis alone: what that axis can take away by itself.

use serde_json::{Value, json};
use trueaxis_compensate::Format;
use trueaxis_kinematics::{AxisKind, MICROMETRE};

use crate::controllers::control;
use crate::{THREE_AXES, calibrated, export, request_of, scenario, tool};

/// The three-axis machine with W, parallel to Z, behind it, or with Y inclined by 30 degrees as on a slant bed.
fn machines() -> [(&'static str, String); 2] {
    let plain: Value = serde_json::from_str(THREE_AXES).unwrap();
    let (mut parallel, mut slanted) = (plain.clone(), plain);
    let axes = parallel["machine"]["axes"].as_array_mut().unwrap();
    let mut w = axes[2].clone();
    w["name"] = "W".into();
    axes.push(w);
    parallel["machine"]["kinematics"]["tool"] = json!(["X", "Y", "Z", "W"]);
    for target in parallel["targets"].as_array_mut().unwrap() {
        target["carried_by"] = "W".into();
    }
    let mut run = parallel["runs"][2].clone();
    (run["name"], run["axis"]) = ("w".into(), "W".into());
    parallel["runs"].as_array_mut().unwrap().push(run);
    parallel["errors"]["W"] =
        json!({ "components": { "EZW": [{ "kind": "polynomial", "coefficients": [0, 30] }] } });
    slanted["machine"]["axes"][1]["direction"] = json!([0, 0.75_f64.sqrt(), 0.5]);
    for axis in ["Y", "Z"] {
        slanted["errors"][axis]
            .as_object_mut()
            .unwrap()
            .remove("location_errors");
    }
    [
        ("parallel", parallel.to_string()),
        ("slanted", slanted.to_string()),
    ]
}

/// The positioning of each axis on its line was halved beside a parallel one, and made worse where axes are not at right
/// angles: the tables held what only several axes take away together.
#[test]
fn positioning_is_taken_away_beside_parallel_and_inclined_axes() {
    for (name, text) in machines() {
        let calibrated = calibrated(&scenario(&text), false);
        let request = request_of(Format::LinuxCnc, &calibrated);
        let export = export(Format::LinuxCnc, &request).unwrap();
        let lacks_squareness = |note: &&String| note.starts_with("no squareness");
        let said = export.notes.iter().find(lacks_squareness);
        assert_eq!(said.is_some(), name == "slanted", "{said:?}");
        let machine = calibrated.machine();
        let control = control(Format::LinuxCnc, &export, machine, tool());
        for (axis, geometry) in machine.axes().iter().enumerate() {
            assert_eq!(geometry.kind(), AxisKind::Linear);
            let along = |position: f64| {
                let mut commanded = vec![0.0; machine.axes().len()];
                commanded[axis] = position;
                let added = control(&commanded)[axis];
                let error = machine.tool_error(&calibrated, &commanded, tool());
                let along_mm = error.translation_mm.dot(&geometry.direction());
                (along_mm, along_mm + added)
            };
            let home = along(0.0);
            let (mut before, mut after): (f64, f64) = (0.0, 0.0);
            for position in calibrated.steps(axis) {
                let at = along(position);
                before = before.max((at.0 - home.0).abs());
                after = after.max((at.1 - home.1).abs());
            }
            println!("{name} {}: {before:.6} -> {after:.6} mm", geometry.name());
            // Along slopes of errors, and the digits of the file.
            assert!(
                before > 10.0 * MICROMETRE && after < 0.1 * MICROMETRE,
                "{name}"
            );
        }
    }
}
