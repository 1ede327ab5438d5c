//! Damaged `campaign.json`, and files that are not there or something else.

use std::fs;

use serde_json::json;

use crate::program::{file_names, run, shipped};
use crate::refused::{
    INPUT, NOT_IDENTIFIABLE, Refusal, assert_calibration_refused, assert_check_refused,
};

#[test]
fn documents() {
    assert_calibration_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "missing comma",
                damage: |files| files.replace("campaign.json", ",", ""),
                code: INPUT,
                says: &["campaign.json line 3", "not valid JSON", "RFC 8259"],
            },
            Refusal {
                name: "cut off",
                damage: |files| {
                    files.text("campaign.json", |text| text[..text.len() / 2].to_owned());
                },
                code: INPUT,
                says: &["campaign.json line", "not valid JSON"],
            },
            Refusal {
                name: "empty file",
                damage: |files| files.text("campaign.json", |_| String::new()),
                code: INPUT,
                says: &["campaign.json", "the file is empty", "saved completely?"],
            },
            Refusal {
                name: "later version",
                damage: |files| files.set("/version", json!(2)),
                code: INPUT,
                says: &["campaign.json", "field version", "2", "newer release"],
            },
            Refusal {
                name: "other program's file",
                damage: |files| files.set("/format", json!("survey")),
                code: INPUT,
                says: &["field format", "\"survey\"", "trueaxis-campaign"],
            },
            Refusal {
                name: "unknown field",
                damage: |files| files.replace("campaign.json", "carried_by", "caried_by"),
                code: INPUT,
                says: &[
                    "field targets[0].caried_by",
                    "unknown",
                    "did you mean `carried_by`?",
                ],
            },
            Refusal {
                name: "unit that the format does not have",
                damage: |files| {
                    files.replace("campaign.json", "length_sigma_um", "length_sigma_mm");
                },
                code: INPUT,
                says: &[
                    "field instrument.length_sigma_mm",
                    "did you mean `length_sigma_um`?",
                ],
            },
            Refusal {
                name: "missing field",
                damage: |files| {
                    files.json(|json| {
                        let axis = json.pointer_mut("/machine/axes/0").unwrap();
                        axis.as_object_mut().unwrap().remove("position_mm");
                    });
                },
                code: INPUT,
                says: &["field machine.axes[0]", "`position_mm` is missing"],
            },
            Refusal {
                name: "unknown axis of a run",
                damage: |files| files.set("/runs/0/axis", json!("B")),
                code: INPUT,
                says: &["field runs[0].axis", "unknown axis `B`", "known: C"],
            },
            Refusal {
                name: "unknown axis of a branch",
                damage: |files| files.set("/machine/kinematics/workpiece/0", json!("A")),
                code: INPUT,
                says: &["field machine.kinematics.workpiece[0]", "unknown axis `A`"],
            },
            Refusal {
                name: "unknown axis of a target",
                damage: |files| files.set("/targets/1/carried_by", json!("Z")),
                code: INPUT,
                says: &["field targets[1].carried_by", "unknown axis `Z`"],
            },
            Refusal {
                name: "two targets of one name",
                damage: |files| files.set("/targets/1/name", json!("P")),
                code: INPUT,
                says: &["field targets[1].name", "`P`", "give each its own"],
            },
            Refusal {
                name: "two stations of one name",
                damage: |files| files.set("/stations/3/name", json!("S1")),
                code: INPUT,
                says: &["field stations[3].name", "`S1`", "give each its own"],
            },
            Refusal {
                name: "station missing from the list",
                damage: |files| {
                    files.json(|json| drop(json["stations"].as_array_mut().unwrap().pop()));
                },
                code: INPUT,
                says: &["lengths.csv line 515, column station", "`S4`"],
            },
            Refusal {
                name: "direction of no length",
                damage: |files| files.set("/machine/axes/0/direction", json!([0, 0, 0])),
                code: INPUT,
                says: &["field machine.axes[0].direction", "expected a unit vector"],
            },
            Refusal {
                name: "negative standard deviation",
                damage: |files| files.set("/instrument/length_sigma_um", json!(-0.3)),
                code: INPUT,
                says: &["field instrument.length_sigma_um", "more than zero"],
            },
            Refusal {
                name: "text for a number",
                damage: |files| files.set("/targets/0/position_mm/2", json!("zero")),
                code: INPUT,
                says: &["field targets[0].position_mm[2]", "zero"],
            },
        ],
    );
}

#[test]
fn files() {
    assert_calibration_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "no campaign.json",
                damage: |files| files.remove("campaign.json"),
                code: INPUT,
                says: &["campaign.json", "no such file", "give the path"],
            },
            Refusal {
                name: "no lengths.csv",
                damage: |files| files.remove("lengths.csv"),
                code: INPUT,
                says: &["lengths.csv", "no such file", "field lengths"],
            },
            Refusal {
                name: "lengths is a folder",
                damage: |files| files.set("/lengths", json!(".")),
                code: INPUT,
                says: &["this is a folder", "field lengths"],
            },
            Refusal {
                name: "lengths and points",
                damage: |files| files.json(|json| json["points"] = json!("points.csv")),
                code: INPUT,
                says: &["both `lengths` and `points`", "choose one"],
            },
            Refusal {
                name: "neither lengths nor points",
                damage: |files| {
                    files.json(|json| drop(json.as_object_mut().unwrap().remove("lengths")));
                },
                code: INPUT,
                says: &["campaign.json", "no data", "`lengths` or `points`"],
            },
            Refusal {
                name: "verification alone cannot be calibrated from",
                damage: |files| {
                    files.json(|json| {
                        json.as_object_mut().unwrap().remove("lengths");
                        json["verification"] = json!([{
                            "name": "DBB", "kind": "ballbar", "ball_mm": [120, 88, 59],
                            "ball_carried_by": "C", "center_mm": [0, 0, 59], "readings": "dbb.csv"
                        }]);
                    });
                    files.add("dbb.csv", "cycle,direction,C,delta_um\n1,1,0,0\n1,1,90,2\n");
                },
                code: NOT_IDENTIFIABLE,
                says: &["campaign.json", "neither lengths nor points"],
            },
        ],
    );
}

#[test]
fn check_refuses_them_as_well() {
    assert_check_refused(
        "fxyz",
        &[
            Refusal {
                name: "no lengths.csv",
                damage: |files| files.remove("lengths.csv"),
                code: INPUT,
                says: &["lengths.csv", "no such file"],
            },
            Refusal {
                name: "unknown field",
                damage: |files| files.replace("campaign.json", "travel", "stroke"),
                code: INPUT,
                says: &["field machine.axes[0].stroke", "unknown"],
            },
        ],
    );
}

#[test]
fn other_files_than_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage");
    let campaign_file = campaign.join("campaign.json").display().to_string();
    run(folder.path(), &["calibrate", &campaign_file, "--out", "."]).assert_good();
    fs::rename(
        folder.path().join("calibration.json"),
        folder.path().join("result.json"),
    )
    .unwrap();
    let before = file_names(folder.path());
    let shipped_file = |name: &str| campaign.join(name).display().to_string();
    for (path, says) in [
        ("result.json".to_owned(), "this is a trueaxis calibration"),
        (shipped_file("scenario.json"), "this is a trueaxis scenario"),
        (shipped_file("truth.json"), "this is a trueaxis truth"),
        (campaign.display().to_string(), "this is a folder"),
        (shipped_file("lengths.csv"), "not valid JSON"),
    ] {
        for verb in ["check", "calibrate"] {
            let outcome = run(folder.path(), &[verb, &path]);
            outcome.assert_failed(&path, INPUT, &[&path, says]);
            assert_eq!(file_names(folder.path()), before);
        }
    }
}
