//! `trueaxis verify`: files, streams, exit codes. Numbers are tested in the library.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::json_schema::faults;
use crate::program::{Outcome, calibrate_shipped, contents, run, shipped};

/// Nothing to compare is no result.
#[test]
fn a_campaign_without_readings_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "fxyz");
    let campaign = shipped("fxyz").join("campaign.json");
    let campaign = campaign.to_str().unwrap();
    let args = [
        "verify",
        "calibrated/calibration.json",
        campaign,
        "--out",
        "verified",
    ];
    let says =
        format!("error[E404] … {campaign} … no verification readings … add them to `verification`");
    run(folder.path(), &args).assert_failed("no readings", 5, &says);
    assert!(!folder.path().join("verified").exists());
}

/// A folder with the calibration of the three-axis machine in `calibrated`, and in `verification` a campaign with readings
/// along X through T: `factor` times what is predicted, with another zero.
fn prepared(factor: f64) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let current = folder.path();
    calibrate_shipped(current, "fxyz");
    let mut positions = "X,Y,Z,x_mm,y_mm,z_mm\n".to_owned();
    (0..=22).for_each(|k| writeln!(positions, "{},0,0,175.6,497.5,312.1", 20 * k).unwrap());
    fs::write(current.join("positions.csv"), positions).unwrap();
    let args = [
        "predict",
        "calibrated/calibration.json",
        "positions.csv",
        "--out",
        ".",
    ];
    run(current, &args).assert_good();
    let predicted = fs::read_to_string(current.join("predicted.csv")).unwrap();
    let mut readings = "cycle,direction,X,Y,Z,deviation_um\n".to_owned();
    for line in predicted.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        for direction in [1, -1] {
            let value = 12.0 + factor * cells[6];
            writeln!(readings, "1,{direction},{},0,0,{value}", cells[0]).unwrap();
        }
    }
    let verification = current.join("verification");
    fs::create_dir(&verification).unwrap();
    let text = fs::read_to_string(shipped("fxyz").join("campaign.json")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["verification"] = json!([{
        "name": "LI along X", "kind": "positioning", "axis": "X", "target_mm": [175.6, 497.5, 312.1],
        "u_um": 0.3, "readings": "li_x.csv"
    }]);
    document["name"] = json!("lines of FXYZ");
    document.as_object_mut().unwrap().remove("lengths");
    fs::write(verification.join("campaign.json"), document.to_string()).unwrap();
    fs::write(verification.join("li_x.csv"), readings).unwrap();
    folder
}

fn verify(current: &Path, options: &[&str]) -> Outcome {
    let args = [
        "verify",
        "calibrated/calibration.json",
        "verification/campaign.json",
    ];
    run(current, &[&args, options].concat())
}

#[test]
fn readings_that_agree() {
    let folder = prepared(1.0);
    let outcome = verify(folder.path(), &["--json", "--fail-on-misfit"]);
    outcome.assert_good();
    let path = "lines-of-fxyz/verification.json";
    for says in [
        "LI along X: positioning, 46 readings at 46 positions and sides",
        "above 1 at 0 of 46 (expected 2.1; p = 1.000): agrees",
        "B 0.00, mean B 0.00",
        "only 1 pass a side, the standard wants five",
        &format!("written: {path}"),
    ] {
        assert!(outcome.stderr.contains(says), "{says}: {}", outcome.stderr);
    }
    let text = fs::read_to_string(folder.path().join(path)).unwrap();
    assert_eq!(text, outcome.stdout);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["format"], "trueaxis-verification");
    let entry = &document["verification"][0];
    assert_eq!(entry["points"].as_array().unwrap().len(), 46);
    assert_eq!(entry["e_n"]["misfit"], false);
    assert_eq!(entry["iso_230_2"][0]["runs"], 1);
    let point = &entry["points"][0];
    let off = point["reading_um"].as_f64().unwrap() - point["predicted_um"].as_f64().unwrap();
    assert!(off.abs() < 1e-3, "{point}");
    assert!(
        point["compensated_um"].as_f64().unwrap().abs() < 1e-3,
        "{point}"
    );
    let before = contents(folder.path());
    assert_eq!(verify(folder.path(), &[]).stdout, "");
    assert_eq!(contents(folder.path()), before);
    // They were not taken with the compensation on.
    let outcome = verify(folder.path(), &["--compensated", "--fail-on-misfit"]);
    assert_eq!(outcome.code, Some(6), "{}", outcome.stderr);
}

/// What is unusual in the campaign is said here, too.
/// A sign or a unit that would bring the readings to the prediction is asked about.
#[test]
fn readings_of_another_sign_or_unit() {
    for (factor, asks) in [
        (-1.0, "commanded less measured?"),
        (1e3, "are they in nm?"),
        (1e-3, "are they in mm?"),
    ] {
        let outcome = verify(prepared(factor).path(), &["--json"]);
        outcome.assert_good();
        assert!(outcome.stderr.contains(asks), "{asks}: {}", outcome.stderr);
        // In the file as well.
        assert!(outcome.stdout.contains(asks), "{asks}: {}", outcome.stdout);
    }
    let outcome = verify(prepared(2.0).path(), &[]);
    assert!(!outcome.stderr.contains("agree:"), "{}", outcome.stderr);
    // Nothing but mm agrees with a compensated machine whatever was read.
    let outcome = verify(prepared(1e-3).path(), &["--compensated"]);
    assert!(
        outcome.stderr.contains("are they in mm?"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn readings_that_may_be_cut_off() {
    let folder = prepared(1.0);
    let path = folder.path().join("verification/li_x.csv");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, &text[..text.len() - 2]).unwrap();
    let outcome = verify(folder.path(), &[]);
    outcome.assert_good();
    let says = "notice: li_x.csv: the last line has no end";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
}

#[test]
fn readings_that_do_not() {
    let folder = prepared(2.0);
    let outcome = verify(folder.path(), &[]);
    outcome.assert_good();
    assert!(
        outcome.stderr.contains("more than chance"),
        "{}",
        outcome.stderr
    );
    let outcome = verify(folder.path(), &["--fail-on-misfit"]);
    assert_eq!(outcome.code, Some(6), "{}", outcome.stderr);
    let says = "the data reject the model (--fail-on-misfit)";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    // Another machine's.
    let other = shipped("rotary-stage").join("campaign.json");
    let args = [
        "verify",
        "calibrated/calibration.json",
        other.to_str().unwrap(),
    ];
    let outcome = run(folder.path(), &args);
    outcome.assert_failed("another machine", 3, "its axes are X Y Z, expected C");
}

/// Point checks: `verify` compares them, `diagnose` says that it does not, and the schema knows them.
#[test]
fn point_checks_are_compared() {
    let folder = prepared(1.0);
    let current = folder.path();
    let path = current.join("verification/campaign.json");
    let mut document = json_of(&path);
    document["verification"] = json!([{
        "name": "ball plate", "kind": "points", "u_um": 0.4, "readings": "plate.csv"
    }]);
    fs::write(&path, document.to_string()).unwrap();
    let plate = "X,Y,Z,dx_um,dz_um\n0,0,0,0,0\n200,100,300,100,\n400,0,300,,100\n";
    fs::write(current.join("verification/plate.csv"), plate).unwrap();
    let calibration = "calibrated/calibration.json";
    let campaign = "verification/campaign.json";
    let verified = run(current, &["verify", calibration, campaign, "--out", "v"]);
    verified.assert_good();
    let says = "ball plate: point checks, 4 readings at 4 coordinates; zero or set-up fitted out";
    assert!(verified.stderr.contains(says), "{}", verified.stderr);
    let document = json_of(&current.join("v/verification.json"));
    let schema = run(current, &["schema", "verification"]);
    let schema: Value = serde_json::from_str(&schema.stdout).unwrap();
    assert_eq!(faults(&schema, &document), [""; 0]);
    let entry = &document["verification"][0];
    assert_eq!(
        (&entry["kind"], &entry["e_n"]["count"]),
        (&json!("points"), &json!(4))
    );
    assert_eq!(entry["points"][3]["coordinate"], "z");
    let arguments = [
        "diagnose",
        campaign,
        "--calibration",
        calibration,
        "--out",
        "d",
    ];
    let diagnosed = run(current, &arguments);
    diagnosed.assert_good();
    assert!(
        diagnosed
            .stderr
            .contains("point checks are not judged here"),
        "{}",
        diagnosed.stderr
    );
    let document: Value = json_of(&current.join("d/diagnosis.json"));
    assert_eq!(document["verdict"], "not_judged");
}

fn json_of(file: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}
