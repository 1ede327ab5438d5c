//! Damage to rows of CSV files.

use crate::fixture::{Files, assert_refused, rotary_table, table_points, three_axes};

#[test]
fn headers() {
    assert_refused(
        &three_axes(),
        &[
            // Missing column.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        lines.iter_mut().for_each(|line| {
                            *line = line[line.find(',').unwrap() + 1..].to_owned();
                        });
                    });
                },
                "lengths.csv line 1, column time_s: the column is missing … found only \
                 station, repeat, run, direction, X, Y, Z, target, length_mm",
            ),
            // Missing axis.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            let mut cells: Vec<&str> = line.split(',').collect();
                            cells.remove(6);
                            *line = cells.join(",");
                        }
                    });
                },
                "lengths.csv line 1, column Y: the column is missing",
            ),
            (
                |f| f.replace("lengths.csv", "length_mm", "lenght_mm"),
                "line 1, column lenght_mm: unknown column … did you mean `length_mm`? … \
                 machine_temp_c",
            ),
            // Column that the format does not have.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        for (i, line) in lines.iter_mut().enumerate() {
                            *line += if i == 0 { ",operator" } else { ",Jo" };
                        }
                    });
                },
                "line 1, column operator: unknown column … known: time_s",
            ),
            (
                |f| f.replace("lengths.csv", ",X,Y,Z,", ",X,Y,C,"),
                "lengths.csv line 1: 2 columns are wrong: `C` is unknown; `Z` is missing; \
                 known: time_s, … X, Y, Z",
            ),
            // A column twice.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            let cell = line.split(',').nth(5).unwrap().to_owned();
                            *line += &format!(",{cell}");
                        }
                    });
                },
                "line 1, column X: the column stands twice",
            ),
            // Most columns wrong.
            (
                |f| {
                    let header = "time_s,station,repeat,run,direction,X,Y,Z,target,length_mm";
                    let wrong = "time,station,station,run,dir,X,Y,target,length_mm,Zet";
                    f.replace("lengths.csv", header, wrong);
                },
                "lengths.csv line 1: 7 columns are wrong: `time` is unknown, did you mean \
                 `time_s`?; `station` stands twice; `dir` is unknown; `Zet` is unknown;  … \
                 `repeat` is missing; `direction` is missing; `Z` is missing; known: \
                 time_s,",
            ),
            (
                |f| f.lines("lengths.csv", |lines| drop(lines.remove(0))),
                "lengths.csv line 1: no column is known … expected the header time_s,station",
            ),
            // Semicolons.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        lines
                            .iter_mut()
                            .for_each(|line| *line = line.replace(',', ";").replace('.', ","));
                    });
                },
                "lengths.csv line 1: the columns are separated by semicolons … expected \
                 commas",
            ),
            // Semicolons, decimal points.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            *line = line.replace(',', ";");
                        }
                    });
                },
                "lengths.csv line 1: the columns are separated by semicolons",
            ),
            // Tabs.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        lines
                            .iter_mut()
                            .for_each(|line| *line = line.replace(',', "\t"));
                    });
                },
                "separated by tabs",
            ),
            (
                |f| f.replace("li_x.csv", "deviation_um", "delta_um"),
                "li_x.csv line 1, column delta_um … deviation_um",
            ),
        ],
    );
}

#[test]
fn cells() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.lines("lengths.csv", |lines| lines[16] = "1,2,3".to_owned()),
                "lengths.csv line 17: found 3 fields, expected 10",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "12,5"),
                "lengths.csv line 17: found 11 fields … decimal comma",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "\"12,5\""),
                "lengths.csv line 17, column length_mm: \"12,5\" is not a number; expected \
                 a decimal point, such as 12.5",
            ),
            (
                |f| f.cell("lengths.csv", 17, "Y", "home"),
                "lengths.csv line 17, column Y: \"home\" is not a number",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "12.5 mm"),
                "line 17, column length_mm: \"12.5 mm\" is not a number … without unit",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "NaN"),
                "line 17, column length_mm: \"NaN\" is not a finite number … remove the row",
            ),
            (
                |f| f.cell("lengths.csv", 17, "time_s", "-inf"),
                "line 17, column time_s: \"-inf\" is not a finite number",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "inf"),
                "line 17, column length_mm: \"inf\" is not a finite … remove the row",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", "1e999"),
                "line 17, column length_mm: \"1e999\" is not a finite number",
            ),
            // The square of which is none, and with whose digits messages would be filled.
            (
                |f| f.cell("lengths.csv", 17, "time_s", "1e308"),
                "line 17, column time_s: \"1e308\" is too large",
            ),
            // Last row cut off.
            (
                |f| {
                    let text = f.0.get_mut("lengths.csv").unwrap();
                    text.truncate(text.len() - 20);
                },
                "lengths.csv line 361 … fields, expected 10",
            ),
            (
                |f| f.cell("lengths.csv", 17, "length_mm", ""),
                "line 17, column length_mm: the cell is empty … remove the row",
            ),
            (
                |f| f.cell("lengths.csv", 17, "X", ""),
                "line 17, column X: the cell is empty",
            ),
            (
                |f| f.cell("lengths.csv", 17, "direction", "0"),
                "line 17, column direction: found \"0\"; expected 1 or -1",
            ),
            (
                |f| f.cell("lengths.csv", 17, "repeat", "0"),
                "line 17, column repeat: found \"0\"; expected a whole number from 1",
            ),
            (
                |f| f.cell("lengths.csv", 17, "repeat", "1.5"),
                "line 17, column repeat: found \"1.5\"",
            ),
            (
                |f| f.cell("li_x.csv", 3, "cycle", "-1"),
                "li_x.csv line 3, column cycle: found \"-1\"; expected a whole number from 1",
            ),
            (
                |f| f.cell("lengths.csv", 17, "station", "S11"),
                "line 17, column station: unknown station `S11` … did you mean `S1`? \
                 known: S1, S2, S3, S4",
            ),
            (
                |f| f.cell("lengths.csv", 17, "target", "k"),
                "line 17, column target: unknown target `k` … did you mean `K`?",
            ),
            (
                |f| f.cell("lengths.csv", 17, "run", "run3"),
                "line 17, column run: unknown run `run3`; known: x, y, z",
            ),
            (
                |f| f.cell("lengths.csv", 17, "X", "441"),
                "line 17, column X: position 441 mm is outside the travel 0 to 440 mm … \
                 `travel` of the axis",
            ),
            (
                |f| f.scale("lengths.csv", "X", 1000.0),
                "line 5, column X: position 100000 mm … looks like um: divide the column \
                 by 1000",
            ),
            (
                |f| f.cell("li_x.csv", 3, "X", "-5"),
                "li_x.csv line 3, column X: position -5 mm is outside the travel 0 to 440 mm",
            ),
        ],
    );
    assert_refused(
        &rotary_table(),
        &[(
            |f| f.cell("lengths.csv", 17, "C", "-22.5"),
            "line 17, column C: position -22.5 deg is outside the travel 0 to 360 deg",
        )],
    );
    assert_refused(
        &table_points(),
        &[
            (
                |f| f.cell("points.csv", 9, "sigma_um", "0"),
                "points.csv line 9, column sigma_um … expected more than zero",
            ),
            (
                |f| f.replace("points.csv", "repeat", "station"),
                "points.csv line 1: 2 columns are wrong: `station` is unknown; `repeat` is \
                 missing",
            ),
        ],
    );
}

#[test]
fn rows_against_each_other() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.cell("lengths.csv", 7, "target", "P"),
                "lengths.csv line 7: target `P` is read a second time … first in line 5",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines.extend_from_within(4..7)),
                "lengths.csv line 362 … stands in line 5 already … remove the duplicated rows",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines.insert(17, lines[16].clone())),
                "lengths.csv line 18 … first in line 17 … keep one",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines.extend_from_within(1..)),
                "lengths.csv line 362 … in line 2 already … duplicated rows",
            ),
            (
                |f| f.lines("lengths.csv", |lines| lines.extend_from_within(5..6)),
                "lengths.csv line 362 … stands in line 6 already",
            ),
            // Axes of two runs exchanged.
            (
                |f| {
                    f.json("\"x\", \"axis\": \"X\"", "\"x\", \"axis\": \"Y\"");
                    f.json("\"y\", \"axis\": \"Y\"", "\"y\", \"axis\": \"X\"");
                },
                "lengths.csv line 5: run `x` is of axis Y … correct the axis",
            ),
            (
                |f| f.replace("lengths.csv", ",X,Y,Z,", ",Y,X,Z,"),
                "lengths.csv line 5: run `x` is of axis X, but X never moves in it, only Y",
            ),
            // The axis, or the file, of another line.
            (
                |f| {
                    f.json(
                        "\"positioning\", \"axis\": \"X\"",
                        "\"positioning\", \"axis\": \"Y\"",
                    );
                },
                "li_x.csv line 3: verification `LI along X` is of axis Y, but Y never moves in it, only X; correct the axis",
            ),
            (
                |f| f.replace("li_x.csv", "X,Y,Z", "Z,Y,X"),
                "li_x.csv line 3: verification `LI along X` is of axis X, but X never moves in it, only Z",
            ),
        ],
    );
}

/// As `cell` of a column from one station is another there.
fn from_second_station(files: &mut Files, column: &str, cell: &str, other: &str) {
    files.column("lengths.csv", column, |own, row| {
        let is_it = own == cell && row["station"] == "S2";
        if is_it { other } else { own }.to_owned()
    });
}

#[test]
fn positions_that_differ_in_the_last_digits() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| from_second_station(f, "X", "100", "100.0002"),
                "lengths.csv line 95, column X: run `x` stops at 100.0002 mm here and at 100 mm in line 5 … \
                 differ in the last digits … give the commanded positions, not what the encoders show … by 0.05 mm",
            ),
            // A parked axis: smaller, and larger than a share of its own jitter.
            (
                |f| from_second_station(f, "Y", "0", "0.003"),
                "lengths.csv line 92, column Y: run `x` stops at 0.003 mm here and at 0 mm in line 2",
            ),
            // All positions as encoders show them, none twice.
            (
                |f| {
                    let count = std::cell::Cell::new(0.0);
                    f.column("lengths.csv", "X", |cell, _| {
                        count.set(count.get() + 1.0);
                        (cell.parse::<f64>().unwrap() + 1e-5 * count.get()).to_string()
                    });
                },
                "column X: run `x` stops at",
            ),
        ],
    );
    assert_refused(
        &rotary_table(),
        &[(
            |f| from_second_station(f, "C", "45", "45.0003"),
            "lengths.csv line 59, column C: run `c` stops at 45.0003 deg here and at 45 deg in line 8",
        )],
    );
    assert_refused(
        &table_points(),
        &[(
            |f| f.cell("points.csv", 10, "C", "45.0003"),
            "points.csv line 10, column C: run `c` stops at 45.0003 deg here and at 45 deg in line 8",
        )],
    );
    // Steps that are meant to differ.
    for other in ["100.06", "100.5"] {
        let mut files = three_axes();
        from_second_station(&mut files, "X", "100", other);
        let campaign = files.read().unwrap();
        assert_eq!(
            campaign.steps.len(),
            three_axes().read().unwrap().steps.len() + 1
        );
    }
    // A fine step within coarse ones: every sweep stops at both positions. Closer together, or if a single station has both,
    // they would be one stop, of which an encoder shows two positions.
    for (fine, stations, is_read) in [
        ("100.02", ",S", true),
        ("100.02", ",S1,", false),
        ("100.0005", ",S", false),
    ] {
        let mut files = three_axes();
        files.lines("lengths.csv", |lines| {
            let header = lines.remove(0);
            let mut all = Vec::new();
            for stop in lines.chunks(3) {
                all.extend_from_slice(stop);
                let is_here = [",x,", ",100,0,0,", stations].map(|part| stop[0].contains(part));
                if is_here == [true; 3] {
                    // Its lengths differ in the last digit.
                    let beside =
                        |line: &String| line.replace(",100,0,0,", &format!(",{fine},0,0,")) + "1";
                    all.extend(stop.iter().map(beside));
                }
            }
            let in_order = all.iter().enumerate().map(|(row, line)| {
                let (_, rest) = line.split_once(',').unwrap();
                format!("{row},{rest}")
            });
            *lines = std::iter::once(header).chain(in_order).collect();
        });
        match is_read {
            true => {
                let steps = files.read().unwrap().steps.len();
                assert_eq!(steps, three_axes().read().unwrap().steps.len() + 1);
            }
            false => {
                let refused = files.read().unwrap_err().to_string();
                assert!(refused.contains("differ in the last digits"), "{refused}");
            }
        }
    }
    // Two runs of one axis, each with its own grid.
    let mut files = three_axes();
    files.json(
        r#"{ "name": "y","#,
        r#"{ "name": "x2", "axis": "X" }, { "name": "y","#,
    );
    files.lines("lengths.csv", |lines| {
        for line in lines {
            let shifted = line
                .replace(",x,", ",x2,")
                .replace(",100,0,0,", ",100.002,0,0,");
            if line.starts_with(|c: char| c.is_ascii_digit()) && line.contains(",S2,") {
                *line = shifted;
            }
        }
    });
    files.read().unwrap();
}

/// What looks like damage but is none.
#[test]
fn harmless_differences() {
    type Change = fn(&mut Files);
    let accepted: [Change; 8] = [
        // Positions rounded differently, first as commanded and first not.
        |f| from_second_station(f, "X", "100", "100.00000000000006"),
        |f| {
            f.column("lengths.csv", "X", |cell, row| match row["station"] {
                "S1" => cell.replace("300", "299.99999999999994"),
                _ => cell.to_owned(),
            });
        },
        // Byte order marks.
        |f| {
            f.0.values_mut().for_each(|text| text.insert(0, '\u{feff}'));
        },
        // CR LF.
        |f| {
            f.0.values_mut()
                .for_each(|text| *text = text.replace('\n', "\r\n"));
        },
        // Trailing blank lines.
        |f| {
            f.0.values_mut().for_each(|text| text.push_str("\n  \n\n"));
        },
        // Blanks around cells.
        |f| {
            f.lines("lengths.csv", |lines| {
                lines
                    .iter_mut()
                    .for_each(|line| *line = line.replace(',', " , "));
            });
        },
        // Quoted cells.
        |f| {
            f.lines("lengths.csv", |lines| {
                lines
                    .iter_mut()
                    .for_each(|line| *line = format!("\"{}\"", line.replace(',', "\",\"")));
            });
        },
        // Minus zero and plus one.
        |f| {
            f.column("lengths.csv", "Z", |cell, _| {
                if cell == "0" {
                    "-0.0".into()
                } else {
                    cell.into()
                }
            });
            f.column("lengths.csv", "direction", |cell, _| {
                if cell == "1" {
                    "+1".into()
                } else {
                    cell.into()
                }
            });
        },
    ];
    let expected = three_axes().read().unwrap();
    for (number, change) in accepted.into_iter().enumerate() {
        let mut files = three_axes();
        change(&mut files);
        assert_eq!(files.read().unwrap(), expected, "{number}");
    }
}

#[test]
fn notices() {
    let notices = |damage: fn(&mut Files)| {
        let mut files = three_axes();
        damage(&mut files);
        files.read().unwrap().notices
    };
    assert_eq!(notices(|_| ()), [""; 0]);
    let back = notices(|f| f.cell("lengths.csv", 8, "time_s", "3"));
    assert_eq!(back.len(), 1);
    assert!(
        back[0].starts_with(
            "lengths.csv line 8, column time_s: the time goes back from 12.5 s to 3 s"
        )
    );
    let unused = notices(|f| {
        f.lines("lengths.csv", |lines| {
            lines.retain(|line| !line.contains(",z,"));
        });
    });
    assert_eq!(unused, ["lengths.csv: run `z` of campaign.json has no row"]);
    // All there, or cut off in its last number.
    let cut = notices(|f| {
        f.0.values_mut()
            .for_each(|text| text.truncate(text.len() - 1));
    });
    assert_eq!(cut.len(), 2, "{cut:?}");
    for (notice, file) in cut.iter().zip(["lengths.csv", "li_x.csv"]) {
        let says = format!("{file}: the last line has no end");
        assert!(notice.starts_with(&says), "{cut:?}");
    }
    let outlier = notices(|f| f.cell("lengths.csv", 17, "length_mm", "99999"));
    assert_eq!(outlier.len(), 1);
    assert!(
        outlier[0].contains("17: target `P`") || outlier[0].contains("and 17"),
        "{outlier:?}"
    );
}
