//! Damaged input files. What is wrong with them is tested where they are read, in `trueaxis-campaign`;
//! here each kind of damage goes through the program once.

use serde_json::json;

use crate::program::{file_names, run, shipped};
use crate::refused::{
    INPUT, NOT_IDENTIFIABLE, Refusal, assert_calibration_refused, assert_check_refused,
};

const DAMAGES: &[Refusal] = &[
    (
        "unknown field",
        |files| files.replace("campaign.json", "carried_by", "caried_by"),
        INPUT,
        "campaign.json line … field targets[0].caried_by … did you mean `carried_by`?",
    ),
    (
        "no lengths.csv",
        |files| files.remove("lengths.csv"),
        INPUT,
        "lengths.csv … no such file … field lengths",
    ),
    (
        "NaN",
        |files| files.cell(101, "length_mm", "NaN"),
        INPUT,
        "lengths.csv line 101, column length_mm … not a finite number … remove the row",
    ),
    (
        "lengths in metres",
        |files| files.scale("length_mm", 1e-3),
        INPUT,
        "lengths.csv line 2, column length_mm … look like metres … multiply them by 1000",
    ),
];

#[test]
fn calibration_is_refused() {
    assert_calibration_refused("fxyz", DAMAGES);
}

#[test]
fn check_refuses_as_well() {
    assert_check_refused("rotary-stage", DAMAGES);
}

#[test]
fn verification_alone_cannot_be_calibrated_from() {
    assert_calibration_refused(
        "rotary-stage",
        &[(
            "verification alone",
            |files| {
                files.json(|json| {
                    json.as_object_mut().unwrap().remove("lengths");
                    json["verification"] = json!([{
                        "name": "DBB", "kind": "ballbar", "ball_mm": [120, 88, 59],
                        "ball_carried_by": "C", "center_mm": [0, 0, 59], "readings": "dbb.csv"
                    }]);
                });
                files.add("dbb.csv", "cycle,direction,C,delta_um\n1,1,0,0\n1,1,90,2\n");
            },
            NOT_IDENTIFIABLE,
            "campaign.json … neither lengths nor points",
        )],
    );
}

#[test]
fn other_files_than_a_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = shipped("rotary-stage");
    let shipped_file = |name: &str| campaign.join(name).display().to_string();
    for (path, says) in [
        (shipped_file("scenario.json"), "this is a trueaxis scenario"),
        (shipped_file("truth.json"), "this is a trueaxis truth"),
        (campaign.display().to_string(), "this is a folder"),
        (shipped_file("lengths.csv"), "not valid JSON"),
    ] {
        for verb in ["check", "calibrate"] {
            let outcome = run(folder.path(), &[verb, &path]);
            outcome.assert_failed(&path, INPUT, &format!("{path} … {says}"));
            assert!(file_names(folder.path()).is_empty());
        }
    }
}
