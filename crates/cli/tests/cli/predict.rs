//! `trueaxis predict`: files, streams, exit codes. Numbers are tested across the crates.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{Outcome, calibrate_shipped, contents, file_names, run, shipped};

const WRONG_INPUT: i32 = 3;

const TABLE: &str = "X,Y,Z,A,C,x_mm,y_mm,z_mm\n\
                     0,0,0,0,0,100,50,400\n\
                     100.5,200,300,-33,355,100,50,400\n\
                     400,400,0,-75,90,0,0,0\n";

/// A folder with the calibration of the five-axis machine in `calibrated`.
fn calibrated() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "five-axis");
    folder
}

fn predict(current: &Path, table: &str, options: &[&str]) -> Outcome {
    fs::write(current.join("positions.csv"), table).unwrap();
    let args = ["predict", "calibrated/calibration.json", "positions.csv"];
    run(current, &[&args, options].concat())
}

#[test]
fn a_row_for_a_row() {
    let folder = calibrated();
    let outcome = predict(folder.path(), TABLE, &["--json"]);
    outcome.assert_good();
    let path = "five-axis-machine/predicted.csv";
    assert!(outcome.stderr.contains(&format!("written: {path}\n")));
    assert!(
        outcome.stderr.contains("1 of them outside the steps"),
        "{}",
        outcome.stderr
    );
    let text = fs::read_to_string(folder.path().join(path)).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(
        lines[0],
        "X,Y,Z,A,C,x_mm,y_mm,z_mm,ex_um,ey_um,ez_um,ea_arcsec,eb_arcsec,ec_arcsec,\
         u_ex_um,u_ey_um,u_ez_um,u_ea_arcsec,u_eb_arcsec,u_ec_arcsec,extrapolated"
    );
    assert_eq!(lines.len(), 4);
    for (line, [begin, end]) in lines[1..].iter().zip([
        ["0,0,0,0,0,100,50,400,", ",0"],
        ["100.5,200,300,-33,355,100,50,400,", ",0"],
        // A was measured from -60°.
        ["400,400,0,-75,90,0,0,0,", ",1"],
    ]) {
        assert!(line.starts_with(begin) && line.ends_with(end), "{line}");
        assert_eq!(line.split(',').count(), 21);
    }
    let document: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(document["format"], "trueaxis-prediction");
    assert_eq!(document["rows"].as_array().unwrap().len(), 3);

    // Same input, same bytes; nothing on standard output unless it is asked for.
    let before = contents(folder.path());
    let again = predict(folder.path(), TABLE, &["--out", "five-axis-machine"]);
    again.assert_good();
    assert_eq!(again.stdout, "");
    assert_eq!(contents(folder.path()), before);
}

#[test]
fn without_a_point_the_reference_point_is_taken() {
    let folder = calibrated();
    let outcome = predict(folder.path(), "Z,C,A,Y,X\n1,2,3,4,5\n", &["--out", "."]);
    outcome.assert_good();
    assert!(
        outcome.stderr.contains("reference point (0, 0, 0) mm"),
        "{}",
        outcome.stderr
    );
    let text = fs::read_to_string(folder.path().join("predicted.csv")).unwrap();
    assert!(text.contains("\n5,4,1,3,2,0,0,0,"), "{text}");
}

#[test]
fn what_is_wrong_is_named_by_row_and_column() {
    let folder = calibrated();
    let names = [file_names(folder.path()), vec!["positions.csv".to_owned()]].concat();
    for (name, from, to, says) in [
        (
            "beyond the travel",
            "400,400,0,",
            "400,400.5,0,",
            "line 4, column Y: position 400.5 mm is outside the travel 0 to 400 mm",
        ),
        (
            "beyond a turn",
            "355",
            "361",
            "line 3, column C: position 361 deg is outside the travel 0 to 360 deg",
        ),
        (
            "no number",
            "100.5",
            "1oo.5",
            "line 3, column X: \"1oo.5\" is not a number",
        ),
        (
            "another name",
            "x_mm",
            "xmm",
            "column xmm: unknown column; did you mean `x_mm`?",
        ),
        ("no such axis", "A,C", "B,C", "2 columns are wrong"),
        ("half a point", ",z_mm\n", ",direction\n", "unknown column"),
        (
            "a decimal comma",
            "100.5",
            "100,5",
            "found 9 fields, expected 8",
        ),
        (
            "an empty cell",
            "100.5",
            "",
            "line 3, column X: the cell is empty",
        ),
    ] {
        let table = TABLE.replacen(from, to, 1);
        let outcome = predict(folder.path(), &table, &[]);
        outcome.assert_failed(name, WRONG_INPUT, says);
        assert_eq!(file_names(folder.path()), names, "{name}");
    }
}

#[test]
fn another_file_is_no_calibration() {
    let folder = calibrated();
    fs::write(folder.path().join("positions.csv"), TABLE).unwrap();
    let campaign = shipped("five-axis").join("campaign.json");
    let args = ["predict", campaign.to_str().unwrap(), "positions.csv"];
    let outcome = run(folder.path(), &args);
    outcome.assert_failed(
        "a campaign",
        WRONG_INPUT,
        "this is a trueaxis campaign, not a calibration",
    );
    // The calibration of another machine has other axes.
    let fxyz = shipped("fxyz").join("campaign.json");
    run(
        folder.path(),
        &["calibrate", fxyz.to_str().unwrap(), "--out", "calibrated"],
    )
    .assert_good();
    let outcome = predict(folder.path(), TABLE, &[]);
    outcome.assert_failed(
        "another machine",
        WRONG_INPUT,
        "positions.csv line 1 … `A` is unknown",
    );
    let outcome = run(folder.path(), &["volume", "calibrated"]);
    let says = "error[E002]: calibrated: this is a folder, expected a file; give the path of a calibration.json";
    outcome.assert_failed("its folder", WRONG_INPUT, says);
    fs::remove_file(folder.path().join("calibrated/covariance.npz")).unwrap();
    let outcome = predict(folder.path(), TABLE, &[]);
    outcome.assert_failed(
        "half of it",
        WRONG_INPUT,
        "covariance.npz: there is no such file; it belongs beside calibration.json",
    );
}
