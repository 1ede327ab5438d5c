//! `trueaxis import calibration`: files, streams, exit codes. Numbers are tested in the library.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{Outcome, calibrate_shipped, contents, file_names, run, shipped};

/// A folder with the tables of the three-axis machine in `tables`.
fn exported() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    calibrate_shipped(folder.path(), "fxyz");
    for format in ["isg", "etalon"] {
        let args = [
            "export",
            format,
            "calibrated/calibration.json",
            "--out",
            "tables",
        ];
        run(folder.path(), &args).assert_good();
    }
    folder
}

fn import(current: &Path, file: &str, options: &[&str]) -> Outcome {
    let machine = shipped("fxyz").join("campaign.json");
    let args = [
        "import",
        "calibration",
        file,
        "--machine",
        machine.to_str().unwrap(),
    ];
    run(current, &[&args, options].concat())
}

#[test]
fn an_imported_calibration_goes_where_others_do() {
    let folder = exported();
    let current = folder.path();
    let outcome = import(current, "tables/etalon.txt", &["--u-um", "1.5", "--json"]);
    outcome.assert_good();
    for says in [
        "tables/etalon.txt: format etalon, machine FXYZ",
        "compare one measured line",
        "location errors in the file: C0Y, A0Z, B0Z",
        "written: etalon/covariance.npz",
    ] {
        assert!(outcome.stderr.contains(says), "{says}: {}", outcome.stderr);
    }
    let text = fs::read_to_string(current.join("etalon/calibration.json")).unwrap();
    assert_eq!(outcome.stdout, text);
    let before = contents(&current.join("etalon"));
    import(current, "tables/etalon.txt", &["--u-um", "1.5"]).assert_good();
    assert_eq!(contents(&current.join("etalon")), before);
    let outcome = import(current, "tables/volcomp.csv", &["--out", "isg"]);
    outcome.assert_good();
    assert!(
        outcome.stderr.contains("no uncertainty was given"),
        "{}",
        outcome.stderr
    );
    assert_eq!(file_names(&current.join("isg")), ["calibration.json"]);

    let lines = shipped("fxyz-lines").join("campaign.json");
    let lines = lines.to_str().unwrap();
    fs::write(current.join("positions.csv"), "X,Y,Z\n0,0,0\n100,100,100\n").unwrap();
    for (calibration, has_u) in [
        ("etalon/calibration.json", true),
        ("isg/calibration.json", false),
    ] {
        for verb in [
            &["predict", calibration, "positions.csv", "--json"][..],
            &["volume", calibration, "--points", "3"],
            &["verify", calibration, lines, "--json"],
            &[
                "compare",
                "calibrated/calibration.json",
                calibration,
                "--json",
            ],
            &["export", "grid", calibration],
        ] {
            let outcome = run(current, &[verb, &["--out", "results"]].concat());
            outcome.assert_good();
            let said = outcome
                .stderr
                .contains("the calibration has no uncertainties");
            assert_eq!(said, !has_u, "{verb:?}: {}", outcome.stderr);
            let unknown = "whether any has changed by more than the noise is not known";
            let says_unknown = outcome.stderr.contains(unknown);
            assert_eq!(
                says_unknown,
                verb[0] == "compare" && !has_u,
                "{}",
                outcome.stderr
            );
            assert!(!outcome.stderr.contains("NaN"), "{}", outcome.stderr);
            assert!(!outcome.stdout.contains("NaN"), "{}", outcome.stdout);
        }
        let text = fs::read_to_string(current.join("results/verification.json")).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        let point = &document["verification"][0]["points"][0];
        assert_eq!(point["e_n"].is_number(), has_u, "{point}");
        let csv = fs::read_to_string(current.join("results/predicted.csv")).unwrap();
        assert_eq!(csv.contains(",,,,,,"), !has_u, "{csv}");
        // Alone it is no report: nothing of it is known.
        let report = run(current, &["report", calibration.split('/').next().unwrap()]);
        assert_eq!(report.code == Some(0), has_u, "{}", report.stderr);
    }
}

#[test]
fn what_is_wrong_is_refused_with_its_place() {
    let folder = exported();
    let current = folder.path();
    let names = file_names(current);
    let text = fs::read_to_string(current.join("tables/etalon.txt")).unwrap();
    // In the points of an error, not between two.
    let inside = text.rfind("Gridpoints = {").unwrap() + 40;
    fs::write(current.join("cut.txt"), &text[..inside]).unwrap();
    import(current, "cut.txt", &[]).assert_failed("cut off", 3, "cut.txt line … expected");
    let told = import(current, "cut.txt", &["--json"]);
    let error: Value = serde_json::from_str(&told.stdout).unwrap();
    let line = 1 + text[..inside].matches('\n').count();
    assert_eq!(
        (&error["file"], &error["line"]),
        (&"cut.txt".into(), &line.into())
    );
    fs::remove_file(current.join("cut.txt")).unwrap();
    let refused = import(current, "nowhere.txt", &[]);
    refused.assert_failed("no file", 3, "nowhere.txt cannot be read … ISG_CSV");
    let refused = import(current, "tables/etalon.txt", &["--u-um", "0"]);
    refused.assert_failed("no u", 2, "expected a number above zero");
    let refused = import(current, "tables/etalon.txt", &["--u-arcsec", "1"]);
    refused.assert_failed("half of u", 2, "--u-um");
    let without = ["import", "calibration", "tables/etalon.txt"];
    run(current, &without).assert_failed("no machine", 2, "--machine");
    let machine = |file: &str| {
        let args = [
            "import",
            "calibration",
            "tables/etalon.txt",
            "--machine",
            file,
        ];
        run(current, &args)
    };
    machine("tables/etalon.txt").assert_failed("no JSON", 3, "tables/etalon.txt");
    machine("nowhere.json").assert_failed("no file", 3, "--machine wants a campaign.json");
    let scenario = shipped("fxyz").join("scenario.json");
    machine(scenario.to_str().unwrap()).assert_failed("a scenario", 3, "campaign");
    // Another machine: its axes have other names.
    let other = shipped("rotary-stage").join("campaign.json");
    let refused = machine(other.to_str().unwrap());
    refused.assert_failed(
        "another machine",
        3,
        "\"C0Y\"; expected an error of an axis of this machine … X0C",
    );
    assert_eq!(file_names(current), names);
    // The machine of a calibration will do.
    machine("calibrated/calibration.json").assert_good();
    // That of a campaign whose name tells of one, too.
    let text = fs::read_to_string(shipped("fxyz").join("campaign.json")).unwrap();
    let renamed = text.replacen("FXYZ machine", "after the trueaxis-calibration", 1);
    fs::write(current.join("renamed.json"), renamed).unwrap();
    machine("renamed.json").assert_good();
}
