//! `trueaxis calibrate` of what is right: files, options, standard output.

use std::fs;
use std::path::Path;

use serde_json::Value;
use trueaxis_campaign::Campaign;

use crate::program::{Outcome, contents, file_names, run, run_line, run_with_environment, shipped};

const USAGE: i32 = 2;
const MISFIT: i32 = 6;

const CAMPAIGNS: [(&str, &str); 3] = [
    ("rotary-stage", "rotary-stage/calibration.json"),
    ("fxyz", "fxyz-machine/calibration.json"),
    ("five-axis", "five-axis-machine/calibration.json"),
];

fn calibrate(current: &Path, campaign: &str, options: &[&str]) -> Outcome {
    let path = shipped(campaign).join("campaign.json");
    let args = [&["calibrate", path.to_str().unwrap()], options].concat();
    run(current, &args)
}

/// `calibration.json` of a shipped campaign with these options.
fn calibration(campaign: &str, options: &[&str]) -> Value {
    let folder = tempfile::tempdir().unwrap();
    calibrate(
        folder.path(),
        campaign,
        &[&["--out", "."], options].concat(),
    )
    .assert_good();
    let text = fs::read(folder.path().join("calibration.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

#[test]
fn writes_to_a_folder_named_after_the_campaign() {
    for (campaign, file) in CAMPAIGNS {
        let folder = tempfile::tempdir().unwrap();
        let outcome = calibrate(folder.path(), campaign, &[]);
        outcome.assert_good();
        assert_eq!(outcome.stdout, "");
        assert!(outcome.stderr.contains(&format!("written: {file}\n")));
        let names = [
            "calibration.json",
            "covariance.npz",
            "report.html",
            "residuals.csv",
        ];
        let files = names.map(|name| file.replace("calibration.json", name));
        assert_eq!(file_names(folder.path()), files);
        let text = fs::read_to_string(folder.path().join(file)).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["format"], "trueaxis-calibration");
        assert_eq!(document["version"], 1);
        assert_eq!(document["method"], "joint");
    }
}

#[test]
fn writes_where_it_is_told_to() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = calibrate(folder.path(), "rotary-stage", &["--out", "a/b"]);
    outcome.assert_good();
    assert!(outcome.stderr.contains("written: a/b/calibration.json\n"));
    let files = [
        "a/b/calibration.json",
        "a/b/covariance.npz",
        "a/b/report.html",
        "a/b/residuals.csv",
    ];
    assert_eq!(file_names(folder.path()), files);
    // Calibrating again replaces the files.
    calibrate(folder.path(), "fxyz", &["--out", "a/b"]).assert_good();
    assert_eq!(file_names(folder.path()), files);
    let text = fs::read_to_string(folder.path().join("a/b/calibration.json")).unwrap();
    assert!(text.contains("FXYZ machine"));
}

/// The covariance that `predict` reads is compared with calibration.json; these matrices are read by other programs.
#[test]
fn matrices_of_an_earlier_calibration_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let options = ["--out", "out", "--no-report"];
    let matrices = [&options[..], &["--covariance", "--reliability"]].concat();
    let first = calibrate(folder.path(), "rotary-stage", &matrices);
    first.assert_good();
    assert!(!first.stderr.contains("earlier calibration"));
    let second = calibrate(folder.path(), "fxyz", &options);
    second.assert_good();
    for name in ["covariance", "reliability"] {
        for ending in ["npy", "json"] {
            let says = format!("out/{name}.{ending} is of an earlier calibration");
            assert!(second.stderr.contains(&says), "{}", second.stderr);
        }
    }
}

/// Two campaigns of one name have one default folder; the second once took the place of the first without a word.
#[test]
fn a_calibration_of_another_machine_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let again = |options: &[&str]| calibrate(folder.path(), "rotary-stage", options);
    let path = folder.path().join("rotary-stage/calibration.json");
    let change = |from: &str, to: &str| {
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from));
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
    };
    again(&[]).assert_good();
    let outcome = again(&[]);
    outcome.assert_good();
    assert!(!outcome.stderr.contains("replaced"), "{}", outcome.stderr);
    change("\"sha256\": \"", "\"sha256\": \"0");
    let outcome = again(&[]);
    outcome.assert_good();
    let says = "calibration.json was of other data and is replaced; --out keeps both";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    change(
        "\"machine\": {\n    \"name\": \"",
        "\"machine\": {\n    \"name\": \"old ",
    );
    let before = contents(folder.path());
    let says = "rotary-stage/calibration.json … is of another machine, old … --out";
    again(&[]).assert_failed("another machine", USAGE, says);
    // What other verbs find goes into the same folder.
    run_line(folder.path(), "diagnose @rotary-stage").assert_failed("diagnosis", USAGE, says);
    assert_eq!(contents(folder.path()), before);
    again(&["--out", "elsewhere"]).assert_good();
}

#[test]
fn a_diagnosis_of_other_data_is_replaced_with_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let again = || run_line(folder.path(), "diagnose @rotary-stage --no-report");
    again().assert_good();
    assert!(!again().stderr.contains("replaced"));
    let path = folder.path().join("rotary-stage/diagnosis.json");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replacen("\"sha256\": \"", "\"sha256\": \"0", 1)).unwrap();
    let says = "diagnosis.json was of other data and is replaced; --out keeps both";
    assert!(again().stderr.contains(says));
}

/// Lengths that the machine of the campaign cannot have caused: no unit explains them, but what carries the targets does. They
/// were refused without it.
#[test]
fn a_mistake_behind_impossible_lengths_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["campaign.json", "lengths.csv"] {
        fs::copy(shipped("fxyz").join(name), folder.path().join(name)).unwrap();
    }
    let path = folder.path().join("campaign.json");
    let text = fs::read_to_string(&path).unwrap();
    let wrong = text.replace("\"carried_by\": \"Z\"", "\"carried_by\": \"Y\"");
    assert_ne!(wrong, text);
    fs::write(&path, wrong).unwrap();
    let says = "error[E215]: likely cause: … carried by Z … the target moves only";
    for verb in ["calibrate", "check"] {
        run_line(folder.path(), &format!("{verb} campaign.json")).assert_failed(verb, 3, says);
    }
}

#[test]
fn folder_that_cannot_be_made() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rotary-stage"), "a file").unwrap();
    let before = contents(folder.path());
    for options in [
        &[][..],
        &["--out", "rotary-stage"],
        &["--out", "rotary-stage/deeper"],
    ] {
        calibrate(folder.path(), "rotary-stage", options).assert_failed(
            "a file in the way",
            USAGE,
            "rotary-stage … cannot be written … a file is in the way … --out",
        );
        assert_eq!(contents(folder.path()), before);
    }
}

#[test]
fn file_that_cannot_be_replaced() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir_all(folder.path().join("out/calibration.json/full")).unwrap();
    calibrate(folder.path(), "rotary-stage", &["--out", "out"]).assert_failed(
        "a folder in the way",
        USAGE,
        "out/calibration.json … cannot be written … --out",
    );
    assert!(file_names(folder.path()).is_empty());
}

#[test]
fn json_prints_the_bytes_of_the_file() {
    for (campaign, file) in CAMPAIGNS {
        let folder = tempfile::tempdir().unwrap();
        let outcome = calibrate(folder.path(), campaign, &["--json"]);
        outcome.assert_good();
        let text = fs::read_to_string(folder.path().join(file)).unwrap();
        assert!(outcome.stdout == text, "{campaign}");
    }
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    for (campaign, _) in CAMPAIGNS {
        let path = shipped(campaign).join("campaign.json");
        let args = ["calibrate", path.to_str().unwrap(), "--json"];
        let print = |environment: &[(&str, &str)]| {
            let folder = tempfile::tempdir().unwrap();
            let outcome = run_with_environment(folder.path(), &args, environment);
            outcome.assert_good();
            outcome.stdout
        };
        let first = print(&[]);
        assert!(first == print(&[]), "{campaign}: two runs differ");
        for threads in ["1", "2"] {
            let other = print(&[("RAYON_NUM_THREADS", threads)]);
            assert!(first == other, "{campaign}: {threads} threads differ");
        }
    }
}

#[test]
fn six_equations() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = calibrate(folder.path(), "fxyz", &["--method", "six"]);
    outcome.assert_good();
    assert!(
        outcome
            .stderr
            .contains("this method against nine equations")
    );
    let six = calibration("fxyz", &["--method", "six"]);
    assert!(six["method"].as_str().unwrap().starts_with("six-equation"));
    let nine = calibration("fxyz", &[]);
    assert_ne!(six["axes"], nine["axes"]);
    assert_eq!(six["stations"][0]["name"], nine["stations"][0]["name"]);
}

#[test]
fn reference_points() {
    let at = |options: &[&str]| {
        let document = calibration("fxyz", options);
        let point = document["axes"][0]["reference_point_mm"]
            .as_array()
            .unwrap();
        let numbers: Vec<f64> = point.iter().map(|x| x.as_f64().unwrap()).collect();
        numbers
    };
    let centroid_mm = [
        (16.338 + 157.086 + 248.925) / 3.0,
        (452.716 + 332.593 + 603.0552) / 3.0,
        (122.416 + 324.879 + 412.4483) / 3.0,
    ];
    for (options, expected_mm) in [
        (&[][..], [0.0; 3]),
        (&["--reference-point", "origin"], [0.0; 3]),
        (&["--reference-point", "centroid"], centroid_mm),
        (
            &["--reference-point", "-100,250.5, 50"],
            [-100.0, 250.5, 50.0],
        ),
    ] {
        for (found, expected) in at(options).iter().zip(expected_mm) {
            assert!((found - expected).abs() < 1e-9, "{options:?}: {found}");
        }
    }
}

/// Points to a tenth of a micrometre; a campaign without a name is said to have none.
#[test]
fn what_is_said_can_be_read() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["campaign.json", "lengths.csv"] {
        let text = fs::read_to_string(shipped("fxyz").join(file)).unwrap();
        let text = text.replace("\"name\": \"FXYZ machine\"", "\"name\": \"\"");
        fs::write(folder.path().join(file), text).unwrap();
    }
    let line = "calibrate campaign.json --out out --no-report --reference-point centroid";
    let outcome = run_line(folder.path(), line);
    outcome.assert_good();
    let says = [
        "(140.783, 462.7881, 286.5811) mm",
        "campaign without a name: 2340 lengths",
    ];
    for says in says {
        assert!(outcome.stderr.contains(says), "{says}: {}", outcome.stderr);
    }
}

#[test]
fn signs_of_the_paper_are_listed_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let without = calibrate(folder.path(), "fxyz", &[]);
    let with = calibrate(folder.path(), "fxyz", &["--paper-signs"]);
    with.assert_good();
    assert!(with.stderr.contains("θxy (Sxy)"));
    assert!(!without.stderr.contains("θxy (Sxy)"));
}

#[test]
fn sides_of_approach_on_request() {
    let positions = |options: &[&str]| {
        let document = calibration("five-axis", options);
        document["axes"][0]["positions"].as_array().unwrap().len()
    };
    assert_eq!(positions(&["--by-direction"]), 2 * positions(&[]));
}

/// Residuals of noise that is not declared say nothing; repeats that agree better with each other than with the model do.
#[test]
fn repeats_that_reject_the_model_fail_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let path = shipped("fxyz").join("scenario.json");
    let mut scenario = trueaxis_simulate::Scenario::read(&path).unwrap();
    scenario.repeats = 2;
    let mut campaign = trueaxis_simulate::simulate(&scenario, 1).unwrap().campaign;
    campaign.instrument.length_sigma_um = None;
    campaign.instrument.repeatability_um = None;
    let fails = |campaign: &Campaign| {
        let path = trueaxis_campaign::write(campaign, folder.path()).unwrap();
        let path = path.to_str().unwrap();
        run(
            folder.path(),
            &["calibrate", path, "--no-report", "--fail-on-misfit"],
        )
    };
    fails(&campaign).assert_good();
    for reading in &mut campaign.lengths.as_mut().unwrap().readings {
        reading.length_mm += 2e-3 * (reading.length_mm / 7.0).sin();
    }
    fails(&campaign).assert_failed("repeats", MISFIT, "all U are … reject the model");
}

/// The five-axis campaign has lost motion, which one curve for both sides cannot hold.
#[test]
fn misfit_fails_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |options: &[&str]| {
        let options = [&["--out", "out", "--fail-on-misfit"], options].concat();
        let outcome = calibrate(folder.path(), "five-axis", &options);
        // The result is there in any case: it is what has to be looked at.
        let file = folder.path().join("out/calibration.json");
        assert!(file.exists());
        fs::remove_file(file).unwrap();
        outcome
    };
    fails(&[]).assert_failed(
        "one curve for both sides",
        MISFIT,
        "reject the model … --by-direction",
    );
    fails(&["--by-direction"]).assert_good();
    for campaign in ["rotary-stage", "fxyz"] {
        calibrate(folder.path(), campaign, &["--fail-on-misfit"]).assert_good();
    }
}
