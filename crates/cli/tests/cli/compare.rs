//! `trueaxis compare`: files, streams, exit codes. Numbers are tested in the library.

use std::fs;

use serde_json::Value;

use crate::program::{file_names, run, shipped};

#[test]
fn two_calibrations_and_two_machines() {
    let folder = tempfile::tempdir().unwrap();
    let current = folder.path();
    for (campaign, out, method) in [
        ("fxyz", "a", "joint"),
        ("fxyz", "b", "nine"),
        ("rotary-stage", "c", "joint"),
    ] {
        let campaign = shipped(campaign).join("campaign.json");
        let args = [
            "calibrate",
            campaign.to_str().unwrap(),
            "--out",
            out,
            "--method",
            method,
        ];
        run(current, &args).assert_good();
    }
    let args = [
        "compare",
        "a/calibration.json",
        "b/calibration.json",
        "--json",
    ];
    let outcome = run(current, &args);
    outcome.assert_good();
    let path = "fxyz-machine/comparison.json";
    assert!(
        outcome.stderr.contains(&format!("written: {path}\n")),
        "{}",
        outcome.stderr
    );
    assert!(outcome.stderr.contains("\n  C0Y "), "{}", outcome.stderr);
    // The same lengths by another path: no machine has changed.
    assert!(
        outcome
            .stderr
            .contains("none of the 21 has changed by more than the noise\nnotice: both follow from the same measurement"),
        "{}",
        outcome.stderr
    );
    let text = fs::read_to_string(current.join(path)).unwrap();
    assert_eq!(text, outcome.stdout);
    let page = fs::read_to_string(current.join("fxyz-machine/report.html")).unwrap();
    assert!(page.contains("No change is seen beyond the noise."));
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["format"], "trueaxis-comparison");
    let exx = &document["differences"]["EXX"];
    for column in ["positions", "first_um", "difference_um", "u_um"] {
        assert_eq!(exx[column].as_array().unwrap().len(), 23, "{column}");
    }
    assert_eq!(
        document["differences"]["B0Z"]["u_arcsec"]
            .as_array()
            .unwrap()
            .len(),
        1
    );

    // Translations of another point of the stage, which its rotations displace: no change of the machine.
    let campaign = shipped("fxyz").join("campaign.json");
    let campaign = campaign.to_str().unwrap();
    let args = [
        "calibrate",
        campaign,
        "--out",
        "d",
        "--reference-point",
        "centroid",
    ];
    run(current, &args).assert_good();
    let names = file_names(current);
    run(
        current,
        &["compare", "a/calibration.json", "d/calibration.json"],
    )
    .assert_failed(
        "two points",
        3,
        "the translations of X are those of the point [0.0, 0.0, 0.0] mm in the first \
         calibration, of [140.783,",
    );

    let outcome = run(
        current,
        &["compare", "a/calibration.json", "c/calibration.json"],
    );
    outcome.assert_failed(
        "two machines",
        3,
        "another machine: its axes are X Y Z, expected C",
    );
    assert_eq!(file_names(current), names);
}

#[test]
fn a_home_that_was_not_measured() {
    let folder = tempfile::tempdir().unwrap();
    let current = folder.path();
    let scenario = fs::read_to_string(shipped("fxyz").join("scenario.json")).unwrap();
    let away = scenario.replace(
        "\"start\": 0, \"stop\": 440",
        "\"start\": 60, \"stop\": 440",
    );
    assert_ne!(away, scenario);
    for (name, scenario) in [("whole", scenario), ("away", away)] {
        fs::write(current.join(format!("{name}.json")), scenario).unwrap();
        let file = format!("{name}.json");
        run(current, &["simulate", &file, "--out", name]).assert_good();
        let campaign = format!("{name}/campaign.json");
        let out = format!("{name}/result");
        run(current, &["calibrate", &campaign, "--out", &out]).assert_good();
    }
    let [whole, away] = ["whole", "away"].map(|name| format!("{name}/result/calibration.json"));
    for (second, said) in [
        (
            &whole,
            "notice: X: home, 0 mm, was not measured in both calibrations: positioning and angles are zero at 60 mm in the \
             first, at 0 mm in the second, and all their differences contain what the curves do in between\n",
        ),
        (
            &away,
            "notice: X: home, 0 mm, was not measured: positioning and angles are zero at 60 mm in both calibrations, so that \
             no difference says what has changed between there and home\n",
        ),
    ] {
        let outcome = run(current, &["compare", &away, second]);
        outcome.assert_good();
        assert!(outcome.stderr.contains(said), "{}", outcome.stderr);
    }
}
