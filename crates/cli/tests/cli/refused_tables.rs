//! Damaged `lengths.csv`.

use crate::refused::{INPUT, Refusal, assert_calibration_refused, assert_check_refused};

#[test]
fn columns() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "missing column",
                damage: |files| files.table(|table| table.remove_column("repeat")),
                code: INPUT,
                says: &["lengths.csv line 1", "column repeat", "missing", "add it"],
            },
            Refusal {
                name: "missing axis",
                damage: |files| files.table(|table| table.remove_column("Y")),
                code: INPUT,
                says: &["lengths.csv line 1", "column Y", "missing", "add it"],
            },
            Refusal {
                name: "column that the format does not have",
                damage: |files| files.table(|table| table.add_column("operator", "Jo")),
                code: INPUT,
                says: &["lengths.csv line 1", "column operator: unknown", "known: "],
            },
            Refusal {
                name: "misspelt column",
                damage: |files| files.replace("lengths.csv", "length_mm", "lenght_mm"),
                code: INPUT,
                says: &["lenght_mm: unknown", "did you mean `length_mm`?"],
            },
            Refusal {
                name: "no header",
                damage: |files| files.text("lengths.csv", |text| second_line_on(&text)),
                code: INPUT,
                says: &["lengths.csv line 1", "expected the header time_s,station"],
            },
            Refusal {
                name: "semicolons",
                damage: |files| files.text("lengths.csv", |text| text.replace(',', ";")),
                code: INPUT,
                says: &["lengths.csv line 1", "semicolons", "expected commas"],
            },
            Refusal {
                name: "semicolons and decimal commas",
                damage: |files| {
                    files.text("lengths.csv", |text| {
                        text.replace(',', ";").replace('.', ",")
                    });
                },
                code: INPUT,
                says: &["lengths.csv line 1", "semicolons", "expected commas"],
            },
            Refusal {
                name: "tabs",
                damage: |files| files.text("lengths.csv", |text| text.replace(',', "\t")),
                code: INPUT,
                says: &["lengths.csv line 1", "tabs", "expected commas"],
            },
        ],
    );
}

#[test]
fn numbers() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "text in a number",
                damage: |files| files.cell(101, "length_mm", "broken"),
                code: INPUT,
                says: &[
                    "lengths.csv line 101, column length_mm",
                    "\"broken\" is not a number",
                ],
            },
            Refusal {
                name: "number with its unit",
                damage: |files| files.cell(101, "X", "20mm"),
                code: INPUT,
                says: &["lengths.csv line 101, column X", "\"20mm\"", "without unit"],
            },
            Refusal {
                name: "decimal comma",
                damage: |files| files.cell(101, "length_mm", "-274,0891255"),
                code: INPUT,
                says: &[
                    "lengths.csv line 101",
                    "11 fields, expected 10",
                    "decimal comma",
                ],
            },
            Refusal {
                name: "decimal comma in quotes",
                damage: |files| files.cell(101, "length_mm", "\"-274,0891255\""),
                code: INPUT,
                says: &["lengths.csv line 101, column length_mm", "decimal point"],
            },
            Refusal {
                name: "NaN",
                damage: |files| files.cell(101, "length_mm", "NaN"),
                code: INPUT,
                says: &[
                    "line 101, column length_mm",
                    "not a finite number",
                    "remove the row",
                ],
            },
            Refusal {
                name: "infinite length",
                damage: |files| files.cell(101, "length_mm", "inf"),
                code: INPUT,
                says: &[
                    "line 101, column length_mm",
                    "not a finite number",
                    "remove the row",
                ],
            },
            Refusal {
                name: "infinite time",
                damage: |files| files.cell(101, "time_s", "-inf"),
                code: INPUT,
                says: &["line 101, column time_s", "not a finite number"],
            },
            Refusal {
                name: "number too large for a computer",
                damage: |files| files.cell(101, "length_mm", "1e999"),
                code: INPUT,
                says: &["line 101, column length_mm", "not a finite number"],
            },
            Refusal {
                name: "empty cell",
                damage: |files| files.cell(101, "length_mm", ""),
                code: INPUT,
                says: &[
                    "line 101, column length_mm",
                    "the cell is empty",
                    "remove the row",
                ],
            },
            Refusal {
                name: "direction 0",
                damage: |files| files.cell(101, "direction", "0"),
                code: INPUT,
                says: &["line 101, column direction", "\"0\"", "expected 1 or -1"],
            },
            Refusal {
                name: "repeat 0",
                damage: |files| files.cell(101, "repeat", "0"),
                code: INPUT,
                says: &["line 101, column repeat", "\"0\"", "whole number from 1"],
            },
            Refusal {
                name: "broken repeat",
                damage: |files| files.cell(101, "repeat", "1.5"),
                code: INPUT,
                says: &["line 101, column repeat", "\"1.5\"", "whole number from 1"],
            },
            Refusal {
                name: "position outside the travel",
                damage: |files| files.cell(101, "Y", "2000"),
                code: INPUT,
                says: &[
                    "line 101, column Y",
                    "2000 mm is outside the travel 0 to 400 mm",
                    "mend the position, or the travel in campaign.json",
                ],
            },
        ],
    );
}

#[test]
fn names() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "unknown target",
                damage: |files| files.cell(101, "target", "p"),
                code: INPUT,
                says: &["line 101, column target", "`p`", "did you mean `P`?"],
            },
            Refusal {
                name: "unknown station",
                damage: |files| files.cell(101, "station", "T7"),
                code: INPUT,
                says: &["line 101, column station", "`T7`", "known: S1, S2, S3, S4"],
            },
            Refusal {
                name: "unknown run",
                damage: |files| files.cell(101, "run", "diagonal"),
                code: INPUT,
                says: &["line 101, column run", "`diagonal`", "known: x, y, z"],
            },
        ],
    );
}

#[test]
fn rows() {
    assert_calibration_refused(
        "fxyz",
        &[
            Refusal {
                name: "row twice",
                damage: |files| {
                    files.table(|table| table.rows.insert(100, table.rows[99].clone()));
                },
                code: INPUT,
                says: &["lengths.csv line 102", "first in line 101", "keep one"],
            },
            Refusal {
                name: "block of rows twice",
                damage: |files| {
                    files.table(|table| {
                        let block = table.rows[99..129].to_vec();
                        table.rows.splice(200..200, block);
                    });
                },
                code: INPUT,
                says: &[
                    "lengths.csv line 202",
                    "in line 101",
                    "remove the duplicated rows",
                ],
            },
            Refusal {
                name: "all rows twice",
                damage: |files| files.table(|table| table.rows.extend(table.rows.clone())),
                code: INPUT,
                says: &[
                    "lengths.csv line 2342",
                    "in line 2 ",
                    "remove the duplicated rows",
                ],
            },
            Refusal {
                name: "last row cut off",
                damage: |files| {
                    files.text("lengths.csv", |text| text[..text.len() - 20].to_owned());
                },
                code: INPUT,
                says: &["lengths.csv line 2341", "fields, expected 10"],
            },
            Refusal {
                name: "no rows",
                damage: |files| files.table(|table| table.rows.clear()),
                code: INPUT,
                says: &["lengths.csv", "no rows below the header"],
            },
            Refusal {
                name: "empty file",
                damage: |files| files.text("lengths.csv", |_| String::new()),
                code: INPUT,
                says: &["lengths.csv", "the file is empty", "saved completely?"],
            },
            Refusal {
                name: "not UTF-8",
                damage: |files| {
                    // ö of Latin-1.
                    files.add(
                        "lengths.csv",
                        b"time_s,station\n4,H\xf6he\n4,S1\n".as_slice(),
                    );
                },
                code: INPUT,
                says: &["lengths.csv line 2", "not UTF-8", "save the file"],
            },
        ],
    );
}

#[test]
fn check_refuses_them_as_well() {
    assert_check_refused(
        "rotary-stage",
        &[
            Refusal {
                name: "empty cell",
                damage: |files| files.cell(17, "C", ""),
                code: INPUT,
                says: &["lengths.csv line 17, column C", "the cell is empty"],
            },
            Refusal {
                name: "position outside the travel",
                damage: |files| files.cell(17, "C", "361"),
                code: INPUT,
                says: &["line 17, column C", "outside the travel 0 to 360 deg"],
            },
            Refusal {
                name: "row twice",
                damage: |files| files.table(|table| table.rows.insert(5, table.rows[4].clone())),
                code: INPUT,
                says: &["lengths.csv line 7", "first in line 6"],
            },
        ],
    );
}

fn second_line_on(text: &str) -> String {
    text[text.find('\n').unwrap() + 1..].to_owned()
}
