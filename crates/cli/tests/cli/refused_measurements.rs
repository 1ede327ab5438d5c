//! Files that read well, but cannot be true: other units, exchanged names, a wrong machine, single
//! wrong readings. None of them may end in an answer. What reading finds is tested where it is read.

use serde_json::json;

use crate::refused::{INPUT, NO_ANSWER, Refusal, assert_calibration_refused};

#[test]
fn units() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "lengths in centimetres",
                damage: |files| files.scale("length_mm", 0.1),
                code: NO_ANSWER,
                says: &[
                    "no position of station",
                    "explains its",
                    "check",
                    "the units",
                ],
            },
            Refusal {
                name: "one axis at half its positions",
                damage: |files| files.scale("X", 0.5),
                code: INPUT,
                says: &["lengths.csv line", "the target moves only 220.000 mm"],
            },
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            // A table in inches could also be a poor geometry.
            Refusal {
                name: "lengths in inches",
                damage: |files| files.scale("length_mm", 1.0 / 25.4),
                code: NO_ANSWER,
                says: &[
                    "no position of station",
                    "explains its",
                    "check",
                    "the units",
                ],
            },
        ],
    );
}

#[test]
fn exchanged_names() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "stations exchanged in one run",
                damage: |files| {
                    files.exchange("station", ["S1", "S2"], |row| row.is(&[("run", "x")]));
                },
                code: NO_ANSWER,
                says: &["no position of station S", "check its name in every row"],
            },
            Refusal {
                name: "stations exchanged in one repeat",
                damage: |files| {
                    files.exchange("station", ["S1", "S2"], |row| row.is(&[("repeat", "2")]));
                },
                code: NO_ANSWER,
                says: &["no position of station S", "check its name in every row"],
            },
            Refusal {
                name: "targets exchanged at one step",
                damage: |files| {
                    files.exchange("target", ["P", "Q"], |row| {
                        row.is(&[("run", "x"), ("X", "200")])
                    });
                },
                code: NO_ANSWER,
                says: &["run x at X = 200 mm", "names its own station and target"],
            },
            Refusal {
                name: "nominal positions of two targets exchanged",
                damage: |files| {
                    files.json(|json| {
                        let targets = json["targets"].as_array_mut().unwrap();
                        let first = targets[0]["position_mm"].clone();
                        targets[0]["position_mm"] = targets[1]["position_mm"].clone();
                        targets[1]["position_mm"] = first;
                    });
                },
                code: NO_ANSWER,
                says: &["no position of station", "nominal positions of the targets"],
            },
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "stations exchanged in half a run",
                damage: |files| {
                    files.exchange("station", ["S3", "S4"], |row| row.number("C") >= 180.0);
                },
                code: NO_ANSWER,
                says: &["no position of station S", "check its name in every row"],
            },
            Refusal {
                name: "targets exchanged in all rows",
                damage: |files| files.exchange("target", ["P", "Q"], |_| true),
                code: NO_ANSWER,
                says: &["no position of station", "nominal positions of the targets"],
            },
        ],
    );
}

#[test]
fn wrong_machine() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "axis reversed",
                damage: |files| files.set("/machine/axes/0/direction", json!([-1, 0, 0])),
                code: NO_ANSWER,
                says: &["no position of station"],
            },
            Refusal {
                name: "two axes exchanged",
                damage: |files| {
                    files.set("/machine/axes/0/direction", json!([0, 1, 0]));
                    files.set("/machine/axes/1/direction", json!([1, 0, 0]));
                },
                code: NO_ANSWER,
                says: &["no position of station"],
            },
            Refusal {
                name: "target on another axis",
                damage: |files| files.set("/targets/0/carried_by", json!("X")),
                code: NO_ANSWER,
                says: &["no position of station"],
            },
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "axis reversed",
                damage: |files| files.set("/machine/axes/0/direction", json!([0, 0, -1])),
                code: NO_ANSWER,
                says: &["no position of station"],
            },
            Refusal {
                name: "axis along X",
                damage: |files| files.set("/machine/axes/0/direction", json!([1, 0, 0])),
                code: NO_ANSWER,
                says: &["no position of station"],
            },
            Refusal {
                name: "axis 100 mm away",
                damage: |files| files.set("/machine/axes/0/position_mm", json!([100, 0, 0])),
                code: NO_ANSWER,
                says: &["no position of station"],
            },
        ],
    );
}

#[test]
fn single_wrong_readings() {
    assert_calibration_refused(
        "fxyz",
        &[Refusal {
            name: "one length enormous",
            damage: |files| files.cell(101, "length_mm", "1e12"),
            code: NO_ANSWER,
            says: &["the adjustment runs away", "line 101 (station S1"],
        }],
    );
}
