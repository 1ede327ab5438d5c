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
    let cases: &[Case] = &[
        (
            |f| f.scale("lengths.csv", "length_mm", 1e-3),
            "lengths.csv line 2, column length_mm … the values of length_mm look like \
             metres, expected mm: multiply them by 1000",
        ),
        (
            |f| f.scale("lengths.csv", "length_mm", 1.0 / INCH_MM),
            "length_mm look like inches, expected mm: multiply them by 25.4",
        ),
        (
            |f| f.scale("lengths.csv", "length_mm", 1e3),
            "length_mm look like micrometres, expected mm: multiply them by 0.001",
        ),
        (
            |f| scale_station(f, "S3", 1e-3),
            "station `S3` … length_mm of station S3 look like metres",
        ),
        (
            |f| scale_station(f, "S3", 1e3),
            "station `S3` … length_mm of station S3 look like micrometres",
        ),
        // One column in metres.
        (
            |f| {
                f.scale("lengths.csv", "Y", 1e-3);
            },
            "values of Y look like metres, expected mm: multiply them by 1000",
        ),
        (
            |f| f.scale("lengths.csv", "X", 1.0 / INCH_MM),
            "values of X look like inches, expected mm: multiply them by 25.4, or say \
             `unit = \"in\"`",
        ),
        // All columns in metres.
        (
            |f| {
                for axis in ["X", "Y", "Z"] {
                    f.scale("lengths.csv", axis, 1e-3);
                }
            },
            "values of X, Y, Z look like metres",
        ),
        // All columns and travels in micrometres.
        (
            |f| {
                for axis in ["X", "Y", "Z"] {
                    f.scale("lengths.csv", axis, 1e3);
                    f.scale("li_x.csv", axis, 1e3);
                }
                let text = f.0.get_mut("campaign.json").unwrap();
                *text = text.replace("[0, 440]", "[0, 440000]");
                *text = text.replace("[0, 400]", "[0, 400000]");
            },
            "values of X, Y, Z look like micrometres, expected mm: multiply them by 0.001",
        ),
        (
            |f| f.column("lengths.csv", "length_mm", |_, _| "-412.3553628".to_owned()),
            "column length_mm … vary by only 0.0000 mm … check the names",
        ),
        (
            |f| f.json("[\"X\", \"Y\", \"Z\"]", "[\"Z\", \"Y\", \"X\"]"),
            "lengths.csv line … moves only 0.000 mm … carried_by",
        ),
        // Target on the wrong axis.
        (
            |f| {
                let text = f.0.get_mut("campaign.json").unwrap();
                *text = text.replace("\"carried_by\": \"Z\"", "\"carried_by\": \"X\"");
            },
            "target moves only 0.000 mm … position_mm and carried_by of the targets",
        ),
    ];
    assert_refused(&three_axes(), cases);
    assert_refused(&without_approx(three_axes()), cases);
}

#[test]
fn lengths_of_a_table() {
    let cases: &[Case] = &[
        (
            |f| f.scale("lengths.csv", "C", std::f64::consts::PI / 180.0),
            "values of C look like radians, expected deg: multiply them by 57.29577951308232",
        ),
        (
            |f| f.scale("lengths.csv", "length_mm", 1e-3),
            "length_mm look like metres",
        ),
        (
            |f| f.scale("lengths.csv", "length_mm", 1e3),
            "length_mm look like micrometres",
        ),
    ];
    assert_refused(&rotary_table(), cases);
    assert_refused(&without_approx(rotary_table()), cases);
    assert_refused(
        &rotary_table(),
        &[(
            |f| f.scale("lengths.csv", "length_mm", 1.0 / INCH_MM),
            "lengths.csv line 2 … approx_mm of station `S1` … look like inches",
        )],
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
            (
                |f| f.scale("points.csv", "C", std::f64::consts::PI / 180.0),
                "values of C look like radians, expected deg",
            ),
            // Targets in inches, with which points in micrometres would move by too little to tell.
            (
                |f| {
                    f.json("[-105.805, 135.341, 0]", "[-4.1656, 5.3284, 0]");
                    f.json("[128.851, 87.816, 39.98]", "[5.0729, 3.4573, 1.574]");
                    f.json("[24.903, -110.858, 15.266]", "[0.9804, -4.3645, 0.601]");
                },
                "nominally 13.527 mm; the values of position_mm of the targets in campaign.json look like inches, expected mm: \
                 multiply them by 25.4",
            ),
            // Targets exchanged in the list.
            (
                |f| {
                    f.json("[-105.805, 135.341, 0]", "[10505.805, 135.341, 0]");
                    f.json("[128.851, 87.816, 39.98]", "[-12128.851, 87.816, 39.98]");
                },
                "no usual mistake of unit explains it … position_mm and carried_by",
            ),
        ],
    );
}

#[test]
fn stations_under_other_names() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| rename_stations(f, &[("S1", "S3"), ("S3", "S1")]),
                "lengths.csv line 182, column station: the lengths of station `S1` fit the \
                 approx_mm of station `S3` … exchange the names in this column, or the \
                 approx_mm in campaign.json",
            ),
            (
                |f| rename_stations(f, &[("S1", "S2"), ("S2", "S4"), ("S4", "S1")]),
                "fit the approx_mm of station",
            ),
            // Approx_mm exchanged.
            (
                |f| {
                    f.json("{ \"name\": \"S2\",", "{ \"name\": \"tmp\",");
                    f.json("{ \"name\": \"S3\",", "{ \"name\": \"S2\",");
                    f.json("{ \"name\": \"tmp\",", "{ \"name\": \"S3\",");
                },
                "the lengths of station `S3` fit the approx_mm of station `S2`",
            ),
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
