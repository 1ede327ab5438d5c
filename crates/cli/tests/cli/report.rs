//! `trueaxis report`: files, streams, exit codes. What the page shows is tested in its crate and in a browser.

use std::fs;

use crate::program::{contents, file_names, run, shipped};

#[test]
fn the_page_is_made_again_with_its_figures() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.display().to_string();
    run(folder.path(), &["calibrate", &campaign]).assert_good();
    let results = folder.path().join("rotary-stage");
    let page = fs::read(results.join("report.html")).unwrap();

    fs::remove_file(results.join("report.html")).unwrap();
    let outcome = run(folder.path(), &["report", "rotary-stage"]);
    outcome.assert_good();
    assert_eq!(outcome.stdout, "");
    let says = "written: rotary-stage/report.html\nwritten: rotary-stage/figures\n";
    assert_eq!(outcome.stderr, says);
    assert!(fs::read(results.join("report.html")).unwrap() == page);
    let figures = file_names(&results.join("figures"));
    assert!(
        figures.contains(&"component-EXC.svg".to_owned()),
        "{figures:?}"
    );
    let figure = fs::read_to_string(results.join("figures/component-EXC.svg")).unwrap();
    assert!(figure.starts_with("<svg xmlns=") && figure.contains("<style>"));
    let before = contents(&results);
    run(folder.path(), &["report", "rotary-stage"]).assert_good();
    assert!(contents(&results) == before);

    // A template of one's own, and one that is wrong.
    fs::write(folder.path().join("own.html"), "{{ campaign }}").unwrap();
    run(
        folder.path(),
        &["report", "rotary-stage", "--template", "own.html"],
    )
    .assert_good();
    assert_eq!(
        fs::read(results.join("report.html")).unwrap(),
        b"Rotary stage"
    );
    fs::write(folder.path().join("own.html"), "{% if %}").unwrap();
    run(
        folder.path(),
        &["report", "rotary-stage", "--template", "own.html"],
    )
    .assert_failed("a wrong template", 3, "template");
    run(
        folder.path(),
        &["report", "rotary-stage", "--template", "none.html"],
    )
    .assert_failed("no template", 3, "none.html … cannot be read");
}

/// With all results of a campaign: a size to be sent by mail, and nothing from a network.
#[test]
fn a_whole_report_is_small_and_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| shipped(name).join("campaign.json").display().to_string();
    let (fxyz, lines) = (file("fxyz"), file("fxyz-lines"));
    run(folder.path(), &["calibrate", &fxyz, "--out", "all"]).assert_good();
    run(folder.path(), &["diagnose", &fxyz, "--out", "all"]).assert_good();
    let verify = ["verify", "all/calibration.json", &lines, "--out", "all"];
    run(folder.path(), &verify).assert_good();
    let page = fs::read_to_string(folder.path().join("all/report.html")).unwrap();
    for part in ["Evidence", "Diagnosis", "Verification", "LI along X"] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    for address in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(address), "{address}");
    }
}

/// Calibrated again in another way, a volumetric error of before is another machine's.
#[test]
fn what_rests_on_an_earlier_calibration_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.display().to_string();
    let page = || fs::read_to_string(folder.path().join("rotary-stage/report.html")).unwrap();
    let calibrate = ["calibrate", &campaign];
    run(folder.path(), &calibrate).assert_good();
    run(folder.path(), &["diagnose", &campaign]).assert_good();
    let volume = ["volume", "rotary-stage/calibration.json", "--points", "3"];
    run(folder.path(), &volume).assert_good();
    assert!(page().contains("Volumetric error") && !page().contains("left out"));
    run(folder.path(), &["calibrate", &campaign, "--method", "nine"]).assert_good();
    let said = "volume.json is of another calibration and left out";
    assert!(page().contains(said) && !page().contains("diagnosis.json is"));
    for name in ["calibration", "diagnosis", "volume"] {
        let file = folder.path().join(format!("rotary-stage/{name}.json"));
        let result: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
        let inputs = result["traceability"]["inputs"].as_array().unwrap();
        assert!(
            inputs
                .iter()
                .all(|i| i["sha256"].as_str().unwrap().len() == 64),
            "{name}"
        );
    }
}

#[test]
fn without_a_result_there_is_no_report() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["report", "."]).assert_failed(
        "an empty folder",
        3,
        "calibration.json … diagnosis.json",
    );
    let says = "error[E001]: no-folder cannot be read; report wants the folder";
    run(folder.path(), &["report", "no-folder"]).assert_failed("no folder", 3, says);
    fs::write(folder.path().join("a-file"), "").unwrap();
    let says = "error[E504]: a-file holds neither … give the folder";
    run(folder.path(), &["report", "a-file"]).assert_failed("a file", 3, says);
    let campaign = shipped("rotary-stage").join("campaign.json");
    let campaign = campaign.display().to_string();
    run(folder.path(), &["calibrate", &campaign, "--no-report"]).assert_good();
    let files = file_names(folder.path());
    assert!(
        !files.iter().any(|name| name.ends_with("report.html")),
        "{files:?}"
    );

    // A file of another version beside the results is no reason to lose them.
    let other = folder.path().join("rotary-stage/volume.json");
    fs::write(other, r#"{ "format": "trueaxis-volume", "version": 9 }"#).unwrap();
    let outcome = run(folder.path(), &["calibrate", &campaign]);
    outcome.assert_good();
    assert!(
        outcome
            .stderr
            .contains("notice: no report.html was written"),
        "{}",
        outcome.stderr
    );
}
