//! Files that read well, but cannot be true: other units, exchanged names, a wrong machine, single
//! wrong readings. None of them may end in an answer.

use serde_json::json;

use crate::refused::{INPUT, NO_ANSWER, Refusal, assert_calibration_refused, assert_check_refused};

#[test]
fn units() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "lengths in metres",
                damage: |files| files.scale("length_mm", 1e-3),
                code: INPUT,
                says: &[
                    "lengths.csv line 2, column length_mm",
                    "look like metres",
                    "multiply them by 1000",
                ],
            },
            Refusal {
                name: "lengths in inches",
                damage: |files| files.scale("length_mm", 1.0 / 25.4),
                code: INPUT,
                says: &[
                    "column length_mm",
                    "look like inches",
                    "multiply them by 25.4",
                ],
            },
            Refusal {
                name: "lengths in micrometres",
                damage: |files| files.scale("length_mm", 1e3),
                code: INPUT,
                says: &[
                    "column length_mm",
                    "look like micrometres",
                    "multiply them by 0.001",
                ],
            },
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
                name: "positions in metres",
                damage: |files| {
                    for axis in ["X", "Y", "Z"] {
                        files.scale(axis, 1e-3);
                    }
                },
                code: INPUT,
                says: &["X, Y, Z look like metres", "multiply them by 1000"],
            },
            Refusal {
                name: "one axis at half its positions",
                damage: |files| files.scale("X", 0.5),
                code: INPUT,
                says: &["lengths.csv line", "the target moves only 220.000 mm"],
            },
            Refusal {
                name: "every length the same",
                damage: |files| files.column("length_mm", |_| "-412.3553628".to_owned()),
                code: INPUT,
                says: &[
                    "column length_mm",
                    "vary by only 0.0000 mm",
                    "check the names",
                ],
            },
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "positions in radians",
                damage: |files| files.scale("C", 1_f64.to_radians()),
                code: INPUT,
                says: &["the values of C look like radians", "expected deg"],
            },
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
fn check_finds_units_as_well() {
    assert_check_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "lengths in metres",
                damage: |files| files.scale("length_mm", 1e-3),
                code: INPUT,
                says: &["look like metres", "multiply them by 1000"],
            },
            Refusal {
                name: "positions in radians",
                damage: |files| files.scale("C", 1_f64.to_radians()),
                code: INPUT,
                says: &["the values of C look like radians", "expected deg"],
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
                code: INPUT,
                says: &["axis X does not move as commanded", "check"],
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
            Refusal {
                name: "axes of two runs exchanged",
                damage: |files| {
                    files.set("/runs/0/axis", json!("Y"));
                    files.set("/runs/1/axis", json!("X"));
                },
                code: INPUT,
                says: &["lengths.csv line", "run `x` is of axis Y", "mend the axis"],
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
                name: "rough positions of two stations exchanged",
                damage: |files| {
                    files.json(|json| {
                        let stations = json["stations"].as_array_mut().unwrap();
                        let places = [
                            [-420, -690, 260],
                            [760, -310, 180],
                            [-560, 480, 520],
                            [290, 520, 910],
                        ];
                        for (station, place) in stations.iter_mut().zip(places) {
                            station["approx_mm"] = json!(place);
                        }
                    });
                },
                code: INPUT,
                says: &["station `S1` fit the approx_mm of station `S2`", "exchange"],
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
                name: "axes in the wrong order",
                damage: |files| files.set("/machine/kinematics/tool", json!(["Z", "Y", "X"])),
                code: INPUT,
                says: &["lengths.csv line", "moves only 0.000 mm", "carried_by"],
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
