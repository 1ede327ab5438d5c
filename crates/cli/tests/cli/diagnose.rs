//! `trueaxis diagnose`, and what `simulate` and `calibrate` make of its files.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::program::{Outcome, calibrate_shipped, contents, file_names, run, shipped};

const USAGE: i32 = 2;
const INPUT: i32 = 3;
const MISFIT: i32 = 6;

/// The instant of the jump, s: in the second station's occupation.
const JUMP_S: f64 = 4000.0;

/// The FXYZ machine with a beam that was interrupted at station S2, 4 µm.
fn interrupted(folder: &Path) -> String {
    let text = fs::read(shipped("fxyz").join("scenario.json")).unwrap();
    let mut scenario: Value = serde_json::from_slice(&text).unwrap();
    scenario["effects"] = json!([ {
        "effect": "dead_path_jump", "subject": { "station": "S2" },
        "parameters": [ { "name": "jump", "value": 4.0, "unit": "um" },
                        { "name": "time", "value": JUMP_S, "unit": "s" } ]
    } ]);
    fs::write(folder.join("scenario.json"), scenario.to_string()).unwrap();
    run(folder, &["simulate", "scenario.json", "--out", "measured"]).assert_good();
    "measured/campaign.json".to_owned()
}

fn json_of(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Value and standard uncertainty of a parameter of the first cause.
fn parameter(diagnosis: &Value, name: &str) -> (f64, f64) {
    let parameters = diagnosis["causes"][0]["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|p| p["name"] == name).unwrap();
    (
        found["value"].as_f64().unwrap(),
        found["u"].as_f64().unwrap(),
    )
}

fn diagnose(folder: &Path, campaign: &str, options: &[&str]) -> Outcome {
    run(folder, &[&["diagnose", campaign], options].concat())
}

#[test]
fn names_the_cause_replays_it_and_takes_it_out() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let campaign = interrupted(folder);
    let outcome = diagnose(folder, &campaign, &["--out", "first", "--json"]);
    outcome.assert_good();
    for part in [
        "the cause is clear",
        "cause: dead path jump of station S2",
        "jump +",
        "beyond doubt",
        "written: first/diagnosis.json\n",
        "written: first/effects.json\n",
        "written: first/replay.json\n",
    ] {
        assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
    }
    let files = [
        "diagnosis.json",
        "effects.json",
        "replay.json",
        "report.html",
    ];
    assert_eq!(file_names(&folder.join("first")), files);
    let text = fs::read_to_string(folder.join("first/diagnosis.json")).unwrap();
    assert!(outcome.stdout == text);
    let first = json_of(&folder.join("first/diagnosis.json"));
    assert_eq!(first["format"], "trueaxis-diagnosis");
    assert_eq!(first["verdict"], "named");
    assert_eq!(first["causes"][0]["subject"]["station"], "S2");
    assert!(first["before"]["rms_um"].as_f64() > first["after"]["rms_um"].as_f64());

    // What the extended model measures has the same cause, of the same size: both estimates have
    // their own noise, and their difference is within 4 standard deviations but once in 16 000 seeds.
    let replay = [
        "simulate",
        "first/replay.json",
        "--out",
        "again",
        "--seed",
        "5",
    ];
    run(folder, &replay).assert_good();
    // And with the misfit as a failure, if that is asked for.
    let options = ["--out", "second", "--fail-on-misfit"];
    diagnose(folder, "again/campaign.json", &options).assert_failed(
        "a jump",
        MISFIT,
        "reject the model",
    );
    let second = json_of(&folder.join("second/diagnosis.json"));
    assert_eq!(second["causes"][0]["effect"], "dead_path_jump");
    assert_eq!(second["causes"][0]["subject"]["station"], "S2");
    let ((a, u_a), (b, u_b)) = (parameter(&first, "jump"), parameter(&second, "jump"));
    assert!((a - b).abs() < 4.0 * u_a.hypot(u_b), "{a} and {b}");

    // Both files give the same calibration; its uncertainty holds that of the jump.
    let calibrated = |file: &str| {
        let args = [
            "calibrate",
            &campaign,
            "--out",
            "out",
            "--with-effects",
            file,
        ];
        let outcome = run(folder, &args);
        outcome.assert_good();
        fs::read(folder.join("out/calibration.json")).unwrap()
    };
    let bytes = calibrated("first/effects.json");
    assert!(bytes == calibrated("first/diagnosis.json"));
    let calibration: Value = serde_json::from_slice(&bytes).unwrap();
    let taken = &calibration["effects_taken_out"][0];
    assert_eq!(taken["effect"], "dead_path_jump");
    let axes = calibration["axes"].as_array().into_iter().flatten();
    let curves = axes.filter_map(|axis| axis["components"].as_object());
    let shares = curves.flat_map(|curves| curves.values().map(|c| &c["budget"]["effects"]));
    assert!(
        shares
            .into_iter()
            .any(|share| share.as_f64().is_some_and(|share| share > 0.0))
    );
}

#[test]
fn clean_data_give_two_lines() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.display().to_string();
    let outcome = diagnose(folder.path(), &campaign, &["--fail-on-misfit"]);
    outcome.assert_good();
    assert_eq!(outcome.stdout, "");
    assert!(outcome.stderr.contains("clean"), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("cause:"), "{}", outcome.stderr);
    let files = ["rotary-stage/diagnosis.json", "rotary-stage/report.html"];
    assert_eq!(file_names(folder.path()), files);
    let diagnosis = json_of(&folder.path().join("rotary-stage/diagnosis.json"));
    assert_eq!(diagnosis["verdict"], "clean");
    assert!(diagnosis["before"]["heldout_rms_um"].is_null());
    assert!(diagnosis["gain"].is_null());

    // A diagnosis without causes in the lengths leaves nothing to take out.
    let file = "rotary-stage/diagnosis.json";
    let args = ["calibrate", &campaign, "--with-effects", file];
    run(folder.path(), &args).assert_failed("no causes", INPUT, &format!("{file} … no effects"));
}

#[test]
fn folder_that_cannot_be_made() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out"), "a file").unwrap();
    let before = contents(folder.path());
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.display().to_string();
    let outcome = diagnose(folder.path(), &campaign, &["--out", "out"]);
    outcome.assert_failed("a file in the way", USAGE, "cannot be written … --out");
    assert_eq!(contents(folder.path()), before);
}

#[test]
fn wrong_files() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = shipped("fxyz").join("scenario.json").display().to_string();
    diagnose(folder.path(), &scenario, &[]).assert_failed(
        "a scenario",
        INPUT,
        "scenario.json … trueaxis scenario, not a campaign",
    );
    let campaign = shipped("fxyz").join("campaign.json").display().to_string();
    for (name, text, says) in [
        ("nothing", None, "No such file"),
        (
            "no JSON",
            Some("{"),
            "neither an effects.json nor a diagnosis.json",
        ),
        (
            "a scenario",
            Some(r#"{ "format": "trueaxis-scenario" }"#),
            "not an effects file; give the path of the effects.json",
        ),
        (
            "an unknown station",
            Some(
                r#"{ "format": "trueaxis-effects", "version": 1, "campaign": "FXYZ machine",
                     "effects": [ { "effect": "dead_path_jump", "subject": { "station": "S9" },
                                    "parameters": [] } ] }"#,
            ),
            "`S9`",
        ),
        (
            "a cause that is seen in part only",
            Some(
                r#"{ "format": "trueaxis-diagnosis", "version": 1, "campaign": "FXYZ machine",
                     "causes": [ { "effect": "dead_path_jump", "level": "lengths", "subject": { "station": "S2" },
                                   "parameters": [ { "name": "jump", "value": 3, "u": null, "unit": "um" } ],
                                   "covariance": [ [ 0.01 ] ] } ] }"#,
            ),
            "dead_path_jump (station S2) is seen in part only",
        ),
        (
            "a later version",
            Some(r#"{ "format": "trueaxis-diagnosis", "version": 2 }"#),
            "expected 1",
        ),
    ] {
        if let Some(text) = text {
            fs::write(folder.path().join("effects.json"), text).unwrap();
        }
        let before = contents(folder.path());
        let args = ["calibrate", &campaign, "--with-effects", "effects.json"];
        let outcome = run(folder.path(), &args);
        outcome.assert_failed(name, INPUT, &format!("effects.json … {says}"));
        assert_eq!(contents(folder.path()), before, "{name}");
    }
}

/// Readings alone, against a calibration that was made before.
#[test]
fn readings_against_a_given_calibration() {
    let folder = tempfile::tempdir().unwrap();
    let current = folder.path();
    calibrate_shipped(current, "fxyz");
    let lines = shipped("fxyz-lines").join("campaign.json");
    let lines = lines.to_str().unwrap();
    let against = |campaign: &str, calibration: &str| {
        let args = [
            "diagnose",
            campaign,
            "--calibration",
            calibration,
            "--out",
            "out",
        ];
        run(current, &args)
    };
    let outcome = against(lines, "calibrated/calibration.json");
    outcome.assert_good();
    let says = "the readings are judged against the calibration `FXYZ machine` that was given";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    let text = fs::read_to_string(current.join("out/diagnosis.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["verdict"], "clean", "{text}");
    assert_eq!(document["levels"].as_array().unwrap().len(), 4);
    // Readings with the compensation on contradict what is predicted without.
    let compensated = shipped("fxyz-compensated").join("campaign.json");
    let compensated = compensated.to_str().unwrap();
    let outcome = against(compensated, "calibrated/calibration.json");
    let asks = "was the compensation on (--compensated)?";
    assert!(outcome.stderr.contains(asks), "{}", outcome.stderr);
    let with = [
        "diagnose",
        compensated,
        "--calibration",
        "calibrated/calibration.json",
        "--compensated",
        "--out",
        "with",
    ];
    run(current, &with).assert_good();
    let document = json_of(&current.join("with/diagnosis.json"));
    assert_eq!(document["verdict"], "clean", "{document}");
    // Another machine, no readings, no calibration.
    let table = shipped("rotary-stage").join("campaign.json");
    against(table.to_str().unwrap(), "calibrated/calibration.json").assert_failed(
        "another machine",
        3,
        "its axes are X Y Z, expected C",
    );
    let own = shipped("fxyz").join("campaign.json");
    against(own.to_str().unwrap(), "calibrated/calibration.json").assert_failed(
        "no readings",
        5,
        "no verification readings … `verification` of campaign.json",
    );
    against(lines, lines).assert_failed("a campaign", 3, "not a calibration");
}
