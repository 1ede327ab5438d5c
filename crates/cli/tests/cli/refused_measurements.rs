//! Files that read well, but cannot be true: other units, exchanged names, a wrong machine, single
//! wrong readings. None of them may end in an answer. What reading finds is tested where it is read.

use serde_json::json;

use crate::refused::{INPUT, NO_ANSWER, assert_calibration_refused};

#[test]
fn units() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "lengths in centimetres",
                |files| files.scale("length_mm", 0.1),
                NO_ANSWER,
                "no position of station … explains its … check … the units",
            ),
            (
                "one axis at half its positions",
                |files| files.scale("X", 0.5),
                INPUT,
                "likely cause: axis X moves 2.0000 times as far … lengths.csv line … the target moves only 220.000 mm",
            ),
            (
                "noise in millimetres",
                |files| {
                    files.set("/instrument/length_sigma_um", json!(0.000269));
                    files.set("/instrument/repeatability_um", json!(0.001));
                },
                NO_ANSWER,
                "error[E303] … contradict each other … noise may be declared in mm: `length_sigma_um` and `repeatability_um` are in µm",
            ),
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            // A table in inches could also be a poor geometry.
            (
                "lengths in inches",
                |files| files.scale("length_mm", 1.0 / 25.4),
                NO_ANSWER,
                "no position of station … explains its … check … the units",
            ),
        ],
    );
}

#[test]
fn exchanged_names() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "stations exchanged in one run",
                |files| {
                    files.exchange("station", ["S1", "S2"], |row| row.is(&[("run", "x")]));
                },
                NO_ANSWER,
                "no position of station S … check its name in every row",
            ),
            (
                "stations exchanged in one repeat",
                |files| {
                    files.exchange("station", ["S1", "S2"], |row| row.is(&[("repeat", "2")]));
                },
                NO_ANSWER,
                "no position of station S … check its name in every row",
            ),
            (
                "targets exchanged at one step",
                |files| {
                    files.exchange("target", ["P", "Q"], |row| {
                        row.is(&[("run", "x"), ("X", "200")])
                    });
                },
                NO_ANSWER,
                "run x at X = 200 mm … names its own station and target",
            ),
            (
                "nominal positions of two targets exchanged",
                |files| {
                    files.json(|json| {
                        let targets = json["targets"].as_array_mut().unwrap();
                        let first = targets[0]["position_mm"].clone();
                        targets[0]["position_mm"] = targets[1]["position_mm"].clone();
                        targets[1]["position_mm"] = first;
                    });
                },
                NO_ANSWER,
                "no position of station … nominal positions of the targets",
            ),
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            (
                "stations exchanged in half a run",
                |files| {
                    files.exchange("station", ["S3", "S4"], |row| row.number("C") >= 180.0);
                },
                NO_ANSWER,
                "no position of station S … check its name in every row",
            ),
            (
                "targets exchanged in all rows",
                |files| files.exchange("target", ["P", "Q"], |_| true),
                NO_ANSWER,
                "no position of station … nominal positions of the targets",
            ),
        ],
    );
}

#[test]
fn wrong_machine() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "two axes exchanged",
                |files| {
                    files.set("/machine/axes/0/direction", json!([0, 1, 0]));
                    files.set("/machine/axes/1/direction", json!([1, 0, 0]));
                },
                NO_ANSWER,
                "no position of station",
            ),
            (
                "target on another axis",
                |files| files.set("/targets/0/carried_by", json!("X")),
                NO_ANSWER,
                "likely cause: target P is carried by Z: correct its `carried_by`; no position of station",
            ),
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            (
                "axis reversed",
                |files| files.set("/machine/axes/0/direction", json!([0, 0, -1])),
                NO_ANSWER,
                "no position of station",
            ),
            (
                "axis along X",
                |files| files.set("/machine/axes/0/direction", json!([1, 0, 0])),
                NO_ANSWER,
                "no position of station",
            ),
            (
                "axis 100 mm away",
                |files| files.set("/machine/axes/0/position_mm", json!([100, 0, 0])),
                NO_ANSWER,
                "no position of station",
            ),
        ],
    );
}

#[test]
fn single_wrong_readings() {
    assert_calibration_refused(
        "fxyz",
        &[(
            "one length enormous",
            |files| files.cell(101, "length_mm", "1e12"),
            NO_ANSWER,
            "the adjustment runs away … line 101 (station S1",
        )],
    );
}
