//! `trueaxis simulate`.

use std::fs;

use serde_json::{Value, json};

use crate::program::{contents, file_names, run, shipped};

const USAGE: i32 = 2;
const INPUT: i32 = 3;

const CAMPAIGNS: [&str; 3] = ["rotary-stage", "fxyz", "five-axis"];
const FILES: [&str; 3] = ["campaign.json", "lengths.csv", "truth.json"];

fn scenario_path(campaign: &str) -> String {
    let path = shipped(campaign).join("scenario.json");
    path.display().to_string()
}

/// What a scenario and a seed give, by file.
fn simulated(campaign: &str, seed: &str) -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().unwrap();
    let path = scenario_path(campaign);
    let args = ["simulate", &path, "--seed", seed, "--out", "new"];
    let outcome = run(folder.path(), &args);
    outcome.assert_good();
    assert_eq!(outcome.stdout, "");
    assert!(
        outcome
            .stderr
            .contains("written: new/campaign.json with its tables, new/truth.json")
    );
    let new = folder.path().join("new");
    assert_eq!(file_names(&new), FILES);
    run(&new, &["check", "campaign.json"]).assert_good();
    FILES.map(|name| fs::read(new.join(name)).unwrap()).to_vec()
}

/// Keeps the shipped campaigns honest: they are what their scenarios say, and name the schema beside them.
#[test]
fn shipped_campaigns_are_reproduced() {
    for campaign in CAMPAIGNS {
        for (name, bytes) in FILES.iter().zip(simulated(campaign, "1")) {
            let shipped = fs::read_to_string(shipped(campaign).join(name)).unwrap();
            let schema = "  \"$schema\": \"../campaign.schema.json\",\n";
            let is_same = bytes == shipped.replace(schema, "").as_bytes();
            assert!(is_same, "{campaign}/{name} differs");
        }
    }
}

#[test]
fn same_seed_same_bytes() {
    let first = simulated("rotary-stage", "7");
    assert!(first == simulated("rotary-stage", "7"));
    let other = simulated("rotary-stage", "8");
    let is_equal: Vec<bool> = first.iter().zip(&other).map(|(a, b)| a == b).collect();
    // The campaign is the same, the lengths are not, and the truth says which seed made them.
    assert_eq!(is_equal, [true, false, false]);
}

#[test]
fn default_folder_and_seed() {
    let folder = tempfile::tempdir().unwrap();
    let outcome = run(folder.path(), &["simulate", &scenario_path("fxyz")]);
    outcome.assert_good();
    assert!(outcome.stderr.contains("2340 lengths, seed 1"));
    let expected = FILES.map(|name| format!("fxyz-machine/{name}"));
    assert_eq!(file_names(folder.path()), expected);
}

#[test]
fn what_was_measured_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let again = || {
        let scenario = scenario_path("fxyz");
        run(folder.path(), &["simulate", &scenario, "--out", "out"])
    };
    again().assert_good();
    again().assert_good();
    fs::remove_file(folder.path().join("out/truth.json")).unwrap();
    let before = contents(folder.path());
    again().assert_failed("measured", USAGE, "out/campaign.json is there already");
    assert_eq!(contents(folder.path()), before);
}

#[test]
fn folder_that_cannot_be_made() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out"), "a file").unwrap();
    let before = contents(folder.path());
    run(
        folder.path(),
        &["simulate", &scenario_path("fxyz"), "--out", "out"],
    )
    .assert_failed("a file in the way", USAGE, "cannot be written … --out");
    assert_eq!(contents(folder.path()), before);
}

/// A change of a scenario and what the message must say.
type Damage = (&'static str, fn(&mut Value), &'static str);

#[test]
fn wrong_scenarios() {
    let damages: [Damage; 9] = [
        (
            "format",
            |s| s["format"] = json!("trueaxis-campaign"),
            "format … not a scenario",
        ),
        (
            "version",
            |s| s["version"] = json!(2),
            "version … expected 1 … found 2",
        ),
        (
            "unknown field",
            |s| s["repeatz"] = json!(3),
            "repeatz … did you mean `repeats`?",
        ),
        (
            "no repeats",
            |s| s["repeats"] = json!(0),
            "repeats … at least 1",
        ),
        (
            "unknown axis",
            |s| s["runs"][0]["axis"] = json!("W"),
            "runs[0].axis … `W` … known: X, Y, Z",
        ),
        (
            "outside the travel",
            |s| s["runs"][0]["sweep"]["stop"] = json!(460),
            "runs[0].sweep … position 460 of axis X … [0, 440]",
        ),
        (
            "endless steps",
            |s| s["runs"][0]["sweep"]["step"] = json!(0),
            "runs[0].sweep.step … more than zero",
        ),
        (
            "negative noise",
            |s| s["instrument"]["length_sigma_um"] = json!(-1),
            "instrument.length_sigma_um … zero or more",
        ),
        (
            "two stations of one name",
            |s| s["stations"][1]["name"] = json!("S1"),
            "stations[1].name … `S1`",
        ),
    ];
    let text = fs::read(scenario_path("fxyz")).unwrap();
    for (name, damage, says) in damages {
        let folder = tempfile::tempdir().unwrap();
        let mut scenario = serde_json::from_slice(&text).unwrap();
        damage(&mut scenario);
        let path = folder.path().join("scenario.json");
        fs::write(&path, serde_json::to_string_pretty(&scenario).unwrap()).unwrap();
        let before = file_names(folder.path());
        let outcome = run(folder.path(), &["simulate", "scenario.json"]);
        outcome.assert_failed(name, INPUT, &format!("scenario.json line … {says}"));
        assert_eq!(file_names(folder.path()), before, "{name}");
    }
}

#[test]
fn other_files_than_a_scenario() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("fxyz");
    for (path, says) in [
        (campaign.join("campaign.json"), "not a scenario"),
        (campaign.join("lengths.csv"), "line 1"),
        (campaign.join("no-such.json"), "No such file"),
        (campaign, "directory"),
    ] {
        let path = path.display().to_string();
        let outcome = run(folder.path(), &["simulate", &path]);
        outcome.assert_failed(&path, INPUT, &format!("{path} … {says}"));
        assert!(file_names(folder.path()).is_empty());
    }
}
