//! Campaigns whose numbers are in another unit, and stations under each other's names.

use crate::fixture::{Case, Files, assert_refused, rotary_table, table_points, three_axes};

const INCH_MM: f64 = 25.4;

fn without_approx(mut files: Files) -> Files {
    files.lines("campaign.json", |lines| {
        for line in lines {
            if let Some(start) = line.find(", \"approx_mm\"") {
                let end = start + line[start..].find(" }").unwrap();
                line.replace_range(start..end, "");
            }
        }
    });
    files
}

/// Scales the lengths of one station.
fn scale_station(files: &mut Files, station: &str, factor: f64) {
    files.column("lengths.csv", "length_mm", |cell, row| {
        let factor = if row["station"] == station {
            factor
        } else {
            1.0
        };
        (cell.parse::<f64>().unwrap() * factor).to_string()
    });
}

fn rename_stations(files: &mut Files, new_names: &[(&str, &str)]) {
    files.column("lengths.csv", "station", |cell, _| {
        let new = new_names.iter().find(|(old, _)| *old == cell);
        new.map_or(cell, |(_, new)| new).to_owned()
    });
}

#[test]
fn lengths_of_three_axes() {
    let cases = [
        Case {
            name: "lengths in metres",
            damage: |f| f.scale("lengths.csv", "length_mm", 1e-3),
            says: &[
                "lengths.csv line 2, column length_mm",
                "the values of length_mm look like metres, expected mm: multiply them by 1000",
            ],
        },
        Case {
            name: "lengths in inches",
            damage: |f| f.scale("lengths.csv", "length_mm", 1.0 / INCH_MM),
            says: &["length_mm look like inches, expected mm: multiply them by 25.4"],
        },
        Case {
            name: "lengths in micrometres",
            damage: |f| f.scale("lengths.csv", "length_mm", 1e3),
            says: &["length_mm look like micrometres, expected mm: multiply them by 0.001"],
        },
        Case {
            name: "one station in metres",
            damage: |f| scale_station(f, "S3", 1e-3),
            says: &["station `S3`", "length_mm of station S3 look like metres"],
        },
        Case {
            name: "one station in micrometres",
            damage: |f| scale_station(f, "S3", 1e3),
            says: &[
                "station `S3`",
                "length_mm of station S3 look like micrometres",
            ],
        },
        Case {
            name: "one column in metres",
            damage: |f| {
                f.scale("lengths.csv", "Y", 1e-3);
            },
            says: &["values of Y look like metres, expected mm: multiply them by 1000"],
        },
        Case {
            name: "one column in inches",
            damage: |f| f.scale("lengths.csv", "X", 1.0 / INCH_MM),
            says: &[
                "values of X look like inches, expected mm: multiply them by 25.4, or say `unit = \"in\"`",
            ],
        },
        Case {
            name: "all columns in metres",
            damage: |f| {
                for axis in ["X", "Y", "Z"] {
                    f.scale("lengths.csv", axis, 1e-3);
                }
            },
            says: &["values of X, Y, Z look like metres"],
        },
        Case {
            name: "all columns and travels in micrometres",
            damage: |f| {
                for axis in ["X", "Y", "Z"] {
                    f.scale("lengths.csv", axis, 1e3);
                    f.scale("li_x.csv", axis, 1e3);
                }
                let text = f.0.get_mut("campaign.json").unwrap();
                *text = text.replace("[0, 440]", "[0, 440000]");
                *text = text.replace("[0, 400]", "[0, 400000]");
            },
            says: &["values of X, Y, Z look like micrometres, expected mm: multiply them by 0.001"],
        },
        Case {
            name: "every length the same",
            damage: |f| f.column("lengths.csv", "length_mm", |_, _| "-412.3553628".to_owned()),
            says: &[
                "column length_mm",
                "vary by only 0.0000 mm",
                "check the names",
            ],
        },
        Case {
            name: "axes in the wrong order",
            damage: |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"Z\", \"Y\", \"X\"]"),
            says: &["lengths.csv line", "moves only 0.000 mm", "carried_by"],
        },
        Case {
            name: "target on the wrong axis",
            damage: |f| {
                let text = f.0.get_mut("campaign.json").unwrap();
                *text = text.replace("\"carried_by\": \"Z\"", "\"carried_by\": \"X\"");
            },
            says: &[
                "target moves only 0.000 mm",
                "position_mm and carried_by of the targets",
            ],
        },
    ];
    assert_refused(&three_axes(), &cases);
    assert_refused(&without_approx(three_axes()), &cases);
}

#[test]
fn lengths_of_a_table() {
    let cases = [
        Case {
            name: "radians",
            damage: |f| f.scale("lengths.csv", "C", std::f64::consts::PI / 180.0),
            says: &[
                "values of C look like radians, expected deg: multiply them by 57.29577951308232",
            ],
        },
        Case {
            name: "lengths in metres",
            damage: |f| f.scale("lengths.csv", "length_mm", 1e-3),
            says: &["length_mm look like metres"],
        },
        Case {
            name: "lengths in micrometres",
            damage: |f| f.scale("lengths.csv", "length_mm", 1e3),
            says: &["length_mm look like micrometres"],
        },
    ];
    assert_refused(&rotary_table(), &cases);
    assert_refused(&without_approx(rotary_table()), &cases);
    assert_refused(
        &rotary_table(),
        &[Case {
            name: "lengths in inches, which only the rough positions of the stations show",
            damage: |f| f.scale("lengths.csv", "length_mm", 1.0 / INCH_MM),
            says: &[
                "lengths.csv line 2",
                "approx_mm of station `S1`",
                "look like inches",
            ],
        }],
    );
}

#[test]
fn points() {
    let scale_points = |files: &mut Files, factor: f64| {
        for column in ["x_mm", "y_mm", "z_mm"] {
            files.scale("points.csv", column, factor);
        }
    };
    for (factor, words) in [
        (1e-3, "metres"),
        (1.0 / INCH_MM, "inches"),
        (1e3, "micrometres"),
    ] {
        let mut files = table_points();
        scale_points(&mut files, factor);
        let message = files.read().unwrap_err().to_string();
        let expected = format!("x_mm, y_mm, z_mm look like {words}, expected mm");
        assert!(message.contains(&expected), "{message}");
        assert!(message.contains("points.csv line"), "{message}");
    }
    assert_refused(
        &table_points(),
        &[
            Case {
                name: "radians",
                damage: |f| f.scale("points.csv", "C", std::f64::consts::PI / 180.0),
                says: &["values of C look like radians, expected deg"],
            },
            Case {
                name: "targets exchanged in the list",
                damage: |f| {
                    f.json("[-105.805, 135.341, 0]", "[10505.805, 135.341, 0]");
                    f.json("[128.851, 87.816, 39.98]", "[-12128.851, 87.816, 39.98]");
                },
                says: &[
                    "no usual mistake of unit explains it",
                    "position_mm and carried_by",
                ],
            },
        ],
    );
}

#[test]
fn stations_under_other_names() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "two exchanged",
                damage: |f| rename_stations(f, &[("S1", "S3"), ("S3", "S1")]),
                says: &[
                    "lengths.csv line 182, column station: the lengths of station `S1` fit the approx_mm of station `S3`",
                    "exchange the names in this column, or the approx_mm in campaign.json",
                ],
            },
            Case {
                name: "three in a circle",
                damage: |f| rename_stations(f, &[("S1", "S2"), ("S2", "S4"), ("S4", "S1")]),
                says: &["fit the approx_mm of station"],
            },
            Case {
                name: "approx_mm exchanged",
                damage: |f| {
                    f.json("{ \"name\": \"S2\",", "{ \"name\": \"tmp\",");
                    f.json("{ \"name\": \"S3\",", "{ \"name\": \"S2\",");
                    f.json("{ \"name\": \"tmp\",", "{ \"name\": \"S3\",");
                },
                says: &["the lengths of station `S3` fit the approx_mm of station `S2`"],
            },
        ],
    );
    // Without rough positions nobody can know.
    let mut files = without_approx(three_axes());
    rename_stations(&mut files, &[("S1", "S3"), ("S3", "S1")]);
    files.read().unwrap();
    // One wrong rough position is no exchange, and it is not needed to solve.
    let mut files = three_axes();
    files.json("[1500, -800, 300]", "[300, 1900, 250]");
    files.read().unwrap();
}
