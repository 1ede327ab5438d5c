//! Simulation and calibration have one rule for the reference frame: what a scenario may contain is
//! what a calibration finds.

use nalgebra::Vector3;
use serde_json::{Value, json};
use trueaxis_calibrate::{Calibration, Settings, calibrate};
use trueaxis_kinematics::{ARCSEC, LocationComponent, MICROMETRE};
use trueaxis_simulate::{Scenario, Simulated, Truth, simulate};
use trueaxis_tests::{Deviation, components, locations, stations};

use crate::round_trip::{SHIPPED, largest, without_noise};

fn linear(name: &str, direction: [f64; 3]) -> Value {
    json!({ "name": name, "kind": "linear", "direction": direction, "travel": [0, 440] })
}

fn run(axis: &str) -> Value {
    let sweep = json!({ "start": 0, "stop": 400, "step": 50 });
    json!({ "name": axis.to_lowercase(), "axis": axis, "sweep": sweep })
}

/// The shipped stations and targets on another machine, all of its axes in the tool branch.
fn machine(axes: &[Value], errors: &Value) -> Value {
    let mut scenario: Value = serde_json::from_str(SHIPPED[0].1).unwrap();
    let names: Vec<&str> = axes.iter().map(|a| a["name"].as_str().unwrap()).collect();
    scenario["machine"]["kinematics"]["tool"] = json!(names);
    scenario["runs"] = names.iter().map(|axis| run(axis)).collect();
    scenario["machine"]["axes"] = json!(axes);
    scenario["errors"] = errors.clone();
    for target in scenario["targets"].as_array_mut().unwrap() {
        target["carried_by"] = json!(names.last());
        target["mounting_error_mm"] = json!([0, 0, 0]);
    }
    scenario
}

fn assert_exact(scenario: &Value) {
    let (calibration, truth) = assert_exact_but_for_locations(scenario);
    let locations = locations(&calibration, &truth);
    let (error, name) = worst(&locations);
    assert!(error < 1e-4 * ARCSEC, "{name} {error:e}");
}

fn assert_exact_but_for_locations(scenario: &Value) -> (Calibration, Truth) {
    let scenario = Scenario::from_json(&scenario.to_string()).unwrap();
    let Simulated { campaign, truth } = simulate(&without_noise(scenario), 1).unwrap();
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    let mut all = components(&calibration, &truth);
    all.extend(stations(&calibration, &truth));
    let (mm, where_mm) = largest(&all, false);
    let (rad, where_rad) = largest(&all, true);
    assert!(mm < 1e-3 * MICROMETRE, "{where_mm} {mm:e}");
    assert!(rad < 1e-4 * ARCSEC, "{where_rad} {rad:e}");
    (calibration, truth)
}

/// mm and rad alike.
fn worst(deviations: &[Deviation]) -> (f64, &str) {
    [false, true]
        .map(|angular| largest(deviations, angular))
        .into_iter()
        .fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a })
}

/// Axes 3 degrees apart span no plane: the second one has both tilts, and the targets give the
/// rotation about the first.
#[test]
fn almost_parallel_axes() {
    let (sin, cos) = 3_f64.to_radians().sin_cos();
    let axes = [linear("X", [1.0, 0.0, 0.0]), linear("U", [cos, sin, 0.0])];
    let errors = json!({
        "X": { "components": { "EYX": [{ "kind": "sine", "amplitude": 3, "period_mm": 150 }] } },
        "U": { "location_errors": {
            "B0U": { "value_arcsec": 21 }, "C0U": { "value_arcsec": -14 }
        } }
    });
    let mut scenario = machine(&axes, &errors);
    // A calibration finds what of a tilt is across the axis; along it a tilt does nothing.
    let (calibration, _) = assert_exact_but_for_locations(&scenario);
    let direction = Vector3::new(cos, sin, 0.0);
    let tilt = Vector3::new(0.0, 21.0, -14.0) * ARCSEC;
    let across = tilt - direction * direction.dot(&tilt);
    for (found, expected) in calibration.axes[1].location_errors.iter().zip([1, 2]) {
        assert_eq!(found.component, LocationComponent::Tilt(expected));
        assert!((found.value - across[expected]).abs() < 1e-4 * ARCSEC);
    }

    // Shifts along the line are the targets' own, a rotation about it would be that of the frame.
    for (target, x) in [0.1, 0.2, -0.3].into_iter().enumerate() {
        scenario["targets"][target]["mounting_error_mm"] = json!([x, 0, 0]);
    }
    assert_exact_but_for_locations(&scenario);
    let homes = [0, 1, 2].map(|target| {
        let home = &scenario["targets"][target]["position_mm"];
        Vector3::from_fn(|i, _| home[i].as_f64().unwrap())
    });
    let centroid = homes.iter().sum::<Vector3<f64>>() / 3.0;
    for (target, home) in homes.iter().enumerate() {
        let turned = Vector3::x().cross(&(home - centroid)) * 1e-4;
        scenario["targets"][target]["mounting_error_mm"] = json!(turned.as_slice());
    }
    let refused = Scenario::from_json(&scenario.to_string()).unwrap_err();
    assert!(format!("{refused:?}").contains("MountingRotation"));
}

/// The targets of one stage are the anchors, those of another stage may be mounted anyhow.
#[test]
fn targets_on_two_stages() {
    let axes = [linear("X", [1.0, 0.0, 0.0]), linear("Y", [0.0, 1.0, 0.0])];
    let errors = json!({
        "X": { "components": { "EYX": [{ "kind": "sine", "amplitude": 3, "period_mm": 150 }] } },
        "Y": { "location_errors": { "C0Y": { "value_arcsec": 21 } } }
    });
    let mut scenario = machine(&axes, &errors);
    let targets = scenario["targets"].as_array_mut().unwrap();
    for (name, position) in [
        ("R", [10, 0, 20]),
        ("S", [300, -50, 60]),
        ("T", [90, 200, 0]),
    ] {
        targets.push(json!({
            "name": name, "carried_by": "X", "position_mm": position,
            "mounting_error_mm": [0.2, -0.1, 0.3]
        }));
    }
    scenario["runs"][0]["targets"] = json!(["R", "S", "T", "Q", "K", "P"]);
    assert_exact(&scenario);
}

/// A target counts once, however many runs see it.
#[test]
fn targets_that_not_all_runs_measure() {
    let axes = [linear("X", [1.0, 0.0, 0.0]), linear("Y", [0.0, 1.0, 0.0])];
    let errors = json!({ "Y": { "location_errors": { "C0Y": { "value_arcsec": 21 } } } });
    let mut scenario = machine(&axes, &errors);
    let targets = scenario["targets"].as_array_mut().unwrap();
    targets.push(json!({ "name": "R", "carried_by": "Y", "position_mm": [10, 0, 20] }));
    for (target, x) in [0.1, -0.3, 0.4, -0.2].into_iter().enumerate() {
        scenario["targets"][target]["mounting_error_mm"] = json!([x, -x, 0.5 * x]);
    }
    scenario["runs"][0]["targets"] = json!(["P", "Q", "K"]);
    scenario["runs"][1]["targets"] = json!(["Q", "K", "R"]);
    assert_exact(&scenario);
}

/// The place along itself of a rotary axis that carries the anchors is that of the frame.
#[test]
fn a_head_has_no_axial_location() {
    let head = json!({
        "name": "B", "kind": "rotary", "direction": [0, 1, 0], "travel": [-90, 90],
        "position_mm": [150, 450, 250]
    });
    let errors = json!({ "B": { "location_errors": { "Y0B": { "value_mm": 0.01 } } } });
    let mut scenario = machine(&[linear("X", [1.0, 0.0, 0.0]), head], &errors);
    scenario["runs"][1]["sweep"] = json!({ "start": -90, "stop": 90, "step": 15 });
    let refused = Scenario::from_json(&scenario.to_string()).unwrap_err();
    assert!(
        format!("{refused:?}").contains("TakenByFrame"),
        "{refused:?}"
    );
    scenario["errors"]["B"]["location_errors"] = json!({ "X0B": { "value_mm": 0.01 } });
    assert_exact(&scenario);
}
