//! `trueaxis volume`: files, streams, exit codes. Numbers are tested in the libraries.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{Outcome, calibrate_shipped, contents, file_names, run, run_with_environment};

fn volume(current: &Path, options: &[&str]) -> Outcome {
    let args = ["volume", "calibrated/calibration.json", "--points", "5"];
    run(current, &[&args, options].concat())
}

#[test]
fn figures_and_a_map() {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "five-axis");
    let outcome = volume(folder.path(), &["--json", "--tool", "-10,20.5,300"]);
    outcome.assert_good();
    let written = folder.path().join("five-axis-machine");
    let files = ["volume.json", "volumetric.csv", "volumetric.vti"];
    assert_eq!(file_names(&written), files);
    let text = fs::read_to_string(written.join("volume.json")).unwrap();
    assert_eq!(outcome.stdout, text);
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["format"], "trueaxis-volume");
    assert_eq!(document["places"], 125);
    assert_eq!(document["tool_home_mm"][1], 20.5);
    assert_eq!(document["sampled"][0]["axis"], "A");
    let max = &document["before"]["zeroed_at_home"]["max_um"];
    assert_eq!(max["value"], document["before"]["worst"]["size_um"]);
    let after = &document["after"];
    assert_eq!(after["all_axes_corrected"]["max_um"], 0.0);
    assert!(after["u_rms_um"].as_f64() > Some(0.1), "{after}");
    assert!(outcome.stderr.contains("the best compensation leaves"));
    assert!(outcome.stderr.contains("worst place"), "{}", outcome.stderr);
    let map = fs::read_to_string(written.join("volumetric.csv")).unwrap();
    assert_eq!(map.lines().count(), 126);

    // The same bytes on one thread; nothing on standard output unless it is asked for.
    let before = contents(&written);
    let args = [
        "volume",
        "calibrated/calibration.json",
        "--points",
        "5",
        "--tool",
        "-10,20.5,300",
    ];
    let again = run_with_environment(folder.path(), &args, &[("RAYON_NUM_THREADS", "1")]);
    again.assert_good();
    assert_eq!(again.stdout, "");
    assert_eq!(contents(&written), before);
}

#[test]
fn a_table_alone_has_no_map() {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "rotary-stage");
    let outcome = volume(folder.path(), &["--out", "v", "--draws", "0"]);
    outcome.assert_good();
    assert_eq!(file_names(&folder.path().join("v")), ["volume.json"]);
    assert!(
        outcome.stderr.contains("no linear axis"),
        "{}",
        outcome.stderr
    );
    let text = fs::read_to_string(folder.path().join("v/volume.json")).unwrap();
    assert!(!text.contains("interval"));
}

#[test]
fn without_a_calibration_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = volume(folder.path(), &[]);
    outcome.assert_failed("no file", 3, "give the path of a calibration.json");
    let outcome = volume(folder.path(), &["--tool", "1,2"]);
    outcome.assert_failed("a point of two", 2, "expected three numbers in mm");
}
