//! Damage to rows of CSV files.

use crate::fixture::{Case, Files, assert_refused, rotary_table, table_points, three_axes};

#[test]
fn headers() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "missing column",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        lines.iter_mut().for_each(|line| {
                            *line = line[line.find(',').unwrap() + 1..].to_owned();
                        });
                    });
                },
                says: &[
                    "lengths.csv line 1, column time_s: the column is missing",
                    "found only station, repeat, run, direction, X, Y, Z, target, length_mm",
                ],
            },
            Case {
                name: "missing axis",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            let mut cells: Vec<&str> = line.split(',').collect();
                            cells.remove(6);
                            *line = cells.join(",");
                        }
                    });
                },
                says: &["lengths.csv line 1, column Y: the column is missing"],
            },
            Case {
                name: "misspelt column",
                damage: |f| f.replace("lengths.csv", "length_mm", "lenght_mm"),
                says: &[
                    "line 1, column lenght_mm: unknown column",
                    "did you mean `length_mm`?",
                    "machine_temp_c",
                ],
            },
            Case {
                name: "column that the format does not have",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        for (i, line) in lines.iter_mut().enumerate() {
                            *line += if i == 0 { ",operator" } else { ",Jo" };
                        }
                    });
                },
                says: &["line 1, column operator: unknown column", "known: time_s"],
            },
            Case {
                name: "column of an axis that the machine lacks",
                damage: |f| f.replace("lengths.csv", ",X,Y,Z,", ",X,Y,C,"),
                says: &[
                    "lengths.csv line 1: 2 columns are wrong: `C` is unknown; `Z` is missing; known: time_s,",
                    "X, Y, Z",
                ],
            },
            Case {
                name: "a column twice",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            let cell = line.split(',').nth(5).unwrap().to_owned();
                            *line += &format!(",{cell}");
                        }
                    });
                },
                says: &["line 1, column X: the column stands twice"],
            },
            Case {
                name: "most columns wrong",
                damage: |f| {
                    let header = "time_s,station,repeat,run,direction,X,Y,Z,target,length_mm";
                    let wrong = "time,station,station,run,dir,X,Y,target,length_mm,Zet";
                    f.replace("lengths.csv", header, wrong);
                },
                says: &[
                    "lengths.csv line 1: 7 columns are wrong: `time` is unknown, did you mean `time_s`?; \
                     `station` stands twice; `dir` is unknown; `Zet` is unknown; ",
                    "`repeat` is missing; `direction` is missing; `Z` is missing; known: time_s,",
                ],
            },
            Case {
                name: "no header",
                damage: |f| f.lines("lengths.csv", |lines| drop(lines.remove(0))),
                says: &[
                    "lengths.csv line 1: no column is known",
                    "expected the header time_s,station",
                ],
            },
            Case {
                name: "semicolons",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        lines
                            .iter_mut()
                            .for_each(|line| *line = line.replace(',', ";").replace('.', ","));
                    });
                },
                says: &[
                    "lengths.csv line 1: the columns are separated by semicolons",
                    "expected commas",
                ],
            },
            Case {
                name: "semicolons, decimal points",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        for line in lines {
                            *line = line.replace(',', ";");
                        }
                    });
                },
                says: &["lengths.csv line 1: the columns are separated by semicolons"],
            },
            Case {
                name: "tabs",
                damage: |f| {
                    f.lines("lengths.csv", |lines| {
                        lines
                            .iter_mut()
                            .for_each(|line| *line = line.replace(',', "\t"));
                    });
                },
                says: &["separated by tabs"],
            },
            Case {
                name: "wrong value column of a verification",
                damage: |f| f.replace("li_x.csv", "deviation_um", "delta_um"),
                says: &["li_x.csv line 1, column delta_um", "deviation_um"],
            },
        ],
    );
}

#[test]
fn cells() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "too few fields",
                damage: |f| f.lines("lengths.csv", |lines| lines[16] = "1,2,3".to_owned()),
                says: &["lengths.csv line 17: found 3 fields, expected 10"],
            },
            Case {
                name: "decimal comma",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "12,5"),
                says: &["lengths.csv line 17: found 11 fields", "decimal comma"],
            },
            Case {
                name: "decimal comma in quotes",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "\"12,5\""),
                says: &[
                    "lengths.csv line 17, column length_mm: \"12,5\" is not a number; expected a decimal point, such as 12.5",
                ],
            },
            Case {
                name: "text in a number",
                damage: |f| f.cell("lengths.csv", 17, "Y", "home"),
                says: &["lengths.csv line 17, column Y: \"home\" is not a number"],
            },
            Case {
                name: "number with its unit",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "12.5 mm"),
                says: &[
                    "line 17, column length_mm: \"12.5 mm\" is not a number",
                    "without unit",
                ],
            },
            Case {
                name: "NaN",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "NaN"),
                says: &[
                    "line 17, column length_mm: \"NaN\" is not a finite number",
                    "remove the row",
                ],
            },
            Case {
                name: "infinite",
                damage: |f| f.cell("lengths.csv", 17, "time_s", "-inf"),
                says: &["line 17, column time_s: \"-inf\" is not a finite number"],
            },
            Case {
                name: "infinite length",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "inf"),
                says: &[
                    "line 17, column length_mm: \"inf\" is not a finite",
                    "remove the row",
                ],
            },
            Case {
                name: "number too large for a computer",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", "1e999"),
                says: &["line 17, column length_mm: \"1e999\" is not a finite number"],
            },
            Case {
                name: "last row cut off",
                damage: |f| {
                    let text = f.0.get_mut("lengths.csv").unwrap();
                    text.truncate(text.len() - 20);
                },
                says: &["lengths.csv line 361", "fields, expected 10"],
            },
            Case {
                name: "empty cell",
                damage: |f| f.cell("lengths.csv", 17, "length_mm", ""),
                says: &[
                    "line 17, column length_mm: the cell is empty",
                    "remove the row",
                ],
            },
            Case {
                name: "empty position",
                damage: |f| f.cell("lengths.csv", 17, "X", ""),
                says: &["line 17, column X: the cell is empty"],
            },
            Case {
                name: "direction 0",
                damage: |f| f.cell("lengths.csv", 17, "direction", "0"),
                says: &["line 17, column direction: found \"0\"; expected 1 or -1"],
            },
            Case {
                name: "repeat 0",
                damage: |f| f.cell("lengths.csv", 17, "repeat", "0"),
                says: &["line 17, column repeat: found \"0\"; expected a whole number from 1"],
            },
            Case {
                name: "broken repeat",
                damage: |f| f.cell("lengths.csv", 17, "repeat", "1.5"),
                says: &["line 17, column repeat: found \"1.5\""],
            },
            Case {
                name: "broken cycle",
                damage: |f| f.cell("li_x.csv", 3, "cycle", "-1"),
                says: &[
                    "li_x.csv line 3, column cycle: found \"-1\"; expected a whole number from 1",
                ],
            },
            Case {
                name: "unknown station",
                damage: |f| f.cell("lengths.csv", 17, "station", "S11"),
                says: &[
                    "line 17, column station: unknown station `S11`",
                    "did you mean `S1`? known: S1, S2, S3, S4",
                ],
            },
            Case {
                name: "unknown target",
                damage: |f| f.cell("lengths.csv", 17, "target", "k"),
                says: &[
                    "line 17, column target: unknown target `k`",
                    "did you mean `K`?",
                ],
            },
            Case {
                name: "unknown run",
                damage: |f| f.cell("lengths.csv", 17, "run", "run3"),
                says: &["line 17, column run: unknown run `run3`; known: x, y, z"],
            },
            Case {
                name: "outside the travel",
                damage: |f| f.cell("lengths.csv", 17, "X", "441"),
                says: &[
                    "line 17, column X: position 441 mm is outside the travel 0 to 440 mm",
                    "travel in campaign.json",
                ],
            },
            Case {
                name: "position in micrometres",
                damage: |f| f.scale("lengths.csv", "X", 1000.0),
                says: &[
                    "line 5, column X: position 100000 mm",
                    "looks like um: divide the column by 1000",
                ],
            },
            Case {
                name: "verification outside the travel",
                damage: |f| f.cell("li_x.csv", 3, "X", "-5"),
                says: &[
                    "li_x.csv line 3, column X: position -5 mm is outside the travel 0 to 440 mm",
                ],
            },
        ],
    );
    assert_refused(
        &rotary_table(),
        &[Case {
            name: "outside the travel of a rotary axis",
            damage: |f| f.cell("lengths.csv", 17, "C", "-22.5"),
            says: &["line 17, column C: position -22.5 deg is outside the travel 0 to 360 deg"],
        }],
    );
    assert_refused(
        &table_points(),
        &[
            Case {
                name: "sigma 0",
                damage: |f| f.cell("points.csv", 9, "sigma_um", "0"),
                says: &[
                    "points.csv line 9, column sigma_um",
                    "expected more than zero",
                ],
            },
            Case {
                name: "station in a points campaign",
                damage: |f| f.replace("points.csv", "repeat", "station"),
                says: &[
                    "points.csv line 1: 2 columns are wrong: `station` is unknown; `repeat` is missing",
                ],
            },
        ],
    );
}

#[test]
fn rows_against_each_other() {
    assert_refused(
        &three_axes(),
        &[
            Case {
                name: "a target twice at one stop",
                damage: |f| f.cell("lengths.csv", 7, "target", "P"),
                says: &[
                    "lengths.csv line 7: target `P` is read a second time",
                    "first in line 5",
                ],
            },
            Case {
                name: "a visit copied to the end",
                damage: |f| f.lines("lengths.csv", |lines| lines.extend_from_within(4..7)),
                says: &[
                    "lengths.csv line 362",
                    "stands in line 5 already",
                    "remove the duplicated rows",
                ],
            },
            Case {
                name: "a row copied below itself",
                damage: |f| f.lines("lengths.csv", |lines| lines.insert(17, lines[16].clone())),
                says: &["lengths.csv line 18", "first in line 17", "keep one"],
            },
            Case {
                name: "all rows twice",
                damage: |f| f.lines("lengths.csv", |lines| lines.extend_from_within(1..)),
                says: &[
                    "lengths.csv line 362",
                    "in line 2 already",
                    "duplicated rows",
                ],
            },
            Case {
                name: "one row copied to the end",
                damage: |f| f.lines("lengths.csv", |lines| lines.extend_from_within(5..6)),
                says: &["lengths.csv line 362", "stands in line 6 already"],
            },
            Case {
                name: "axes of two runs exchanged",
                damage: |f| {
                    f.json("\"x\", \"axis\": \"X\"", "\"x\", \"axis\": \"Y\"");
                    f.json("\"y\", \"axis\": \"Y\"", "\"y\", \"axis\": \"X\"");
                },
                says: &[
                    "lengths.csv line 5: run `x` is of axis Y",
                    "correct the axis",
                ],
            },
            Case {
                name: "columns exchanged",
                damage: |f| f.replace("lengths.csv", ",X,Y,Z,", ",Y,X,Z,"),
                says: &[
                    "lengths.csv line 5: run `x` is of axis X, but X never moves in it, only Y",
                ],
            },
        ],
    );
}

/// What looks like damage but is none.
#[test]
fn harmless_differences() {
    type Change = fn(&mut Files);
    let accepted: [(&str, Change); 6] = [
        ("byte order marks", |f| {
            f.0.values_mut().for_each(|text| text.insert(0, '\u{feff}'));
        }),
        ("CR LF", |f| {
            f.0.values_mut()
                .for_each(|text| *text = text.replace('\n', "\r\n"));
        }),
        ("trailing blank lines", |f| {
            f.0.values_mut().for_each(|text| text.push_str("\n  \n\n"));
        }),
        ("blanks around cells", |f| {
            f.lines("lengths.csv", |lines| {
                lines
                    .iter_mut()
                    .for_each(|line| *line = line.replace(',', " , "));
            });
        }),
        ("quoted cells", |f| {
            f.lines("lengths.csv", |lines| {
                lines
                    .iter_mut()
                    .for_each(|line| *line = format!("\"{}\"", line.replace(',', "\",\"")));
            });
        }),
        ("minus zero and plus one", |f| {
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
        }),
    ];
    let expected = three_axes().read().unwrap();
    for (name, change) in accepted {
        let mut files = three_axes();
        change(&mut files);
        assert_eq!(files.read().unwrap(), expected, "{name}");
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
