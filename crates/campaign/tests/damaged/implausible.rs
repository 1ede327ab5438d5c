//! Readings that no machine gives: states of no hall, copies, rows in another order, times that are no
//! seconds.

use crate::fixture::{Files, assert_refused, rotary_table, table_points, three_axes};

/// Adds a column with the same cell in every row.
fn log(files: &mut Files, name: &str, cell: &str) {
    files.lines("lengths.csv", |lines| {
        for (i, line) in lines.iter_mut().enumerate() {
            *line += &format!(",{}", if i == 0 { name } else { cell });
        }
    });
}

/// Sorts the rows by the cells of these columns; the header stays.
fn sort(files: &mut Files, file: &str, columns: &[&str]) {
    files.lines(file, |lines| {
        let header: Vec<&str> = lines[0].split(',').collect();
        let indices: Vec<usize> = columns
            .iter()
            .map(|column| header.iter().position(|c| c == column).unwrap())
            .collect();
        lines[1..].sort_by_cached_key(|line| {
            let cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            let key = indices.iter().map(|&i| format!("{:0>9}", cells[i]));
            key.collect::<Vec<String>>()
        });
    });
}

/// The rows of one station again as repeat 2, ten hours later; with `change` of each length.
fn repeat(files: &mut Files, station: &str, change: impl Fn(usize, f64) -> f64) {
    files.lines("lengths.csv", |lines| {
        let start = lines.iter().position(|l| l.contains(station)).unwrap();
        let end = 1 + lines.iter().rposition(|l| l.contains(station)).unwrap();
        let mut copies = Vec::new();
        for (i, line) in lines[start..end].iter().enumerate() {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            cells[0] = (36_000.0 + cells[0].parse::<f64>().unwrap()).to_string();
            cells[2] = "2".to_owned();
            let length = cells.last_mut().unwrap();
            *length = change(i, length.parse().unwrap()).to_string();
            copies.push(cells.join(","));
        }
        lines.extend(copies);
    });
}

fn notices(files: &Files) -> Vec<String> {
    files.read().unwrap().notices
}

#[test]
fn states_of_no_hall() {
    assert_refused(
        &three_axes(),
        &[
            // Machine at 2930 degrees.
            (
                |f| {
                    log(f, "machine_temp_spindle_c", "20.5");
                    f.cell("lengths.csv", 17, "machine_temp_spindle_c", "2930");
                },
                "lengths.csv line 17, column machine_temp_spindle_c: a temperature of 2930 \
                 deg C … expected -40 to 150 deg C; is the decimal point missing, as in \
                 29.3?",
            ),
            (
                |f| log(f, "air_temp_c", "293.2"),
                "lengths.csv line 2, column air_temp_c: a temperature of 293.2 deg C … \
                 kelvin: subtract 273.15",
            ),
            (
                |f| log(f, "air_pressure_hpa", "101325"),
                "line 2, column air_pressure_hpa … Pa: divide by 100",
            ),
            (
                |f| log(f, "air_humidity_pct", "-1"),
                "line 2, column air_humidity_pct … expected 0 to 105 %",
            ),
        ],
    );
    let mut files = three_axes();
    log(&mut files, "air_humidity_pct", "0.45");
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(said[0].starts_with("lengths.csv, column air_humidity_pct: no value is above 1"));
    let mut files = three_axes();
    log(&mut files, "machine_temp_x_c", "");
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(said[0].starts_with("lengths.csv, column machine_temp_x_c: every cell is empty"));
}

#[test]
fn a_copied_repeat_is_said_and_a_measured_one_is_not() {
    let mut files = three_axes();
    repeat(&mut files, ",S2,", |_, length_mm| length_mm);
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(
        said[0].starts_with(
            "lengths.csv line 362: repeat 2 of run `x` from station `S2` equals repeat 1 (line 92) in all \
             30 readings to the last digit (and 2 more like it); a copy is no second measurement"
        ),
        "{said:?}"
    );

    let mut files = three_axes();
    repeat(&mut files, ",S2,", |i, length_mm| {
        length_mm + if i % 30 == 7 { 1e-4 } else { 0.0 }
    });
    assert_eq!(notices(&files), [""; 0], "one length of thirty differs");

    let mut files = table_points();
    files.lines("points.csv", |lines| {
        let copies: Vec<String> = lines[1..]
            .iter()
            .map(|line| {
                let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
                cells[0] = (9000.0 + cells[0].parse::<f64>().unwrap()).to_string();
                cells[1] = "2".to_owned();
                cells.join(",")
            })
            .collect();
        lines.extend(copies);
    });
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(
        said[0].starts_with("points.csv line 53: repeat 2 of run `c` equals repeat 1 (line 2)")
    );
}

#[test]
fn a_station_copied_from_another() {
    assert_refused(
        &rotary_table(),
        &[
            // The lengths of S3 are those of S1.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        for i in 0..51 {
                            let length = lines[1 + i].rsplit(',').next().unwrap().to_owned();
                            let row = &mut lines[1 + 2 * 51 + i];
                            row.truncate(row.rfind(',').unwrap() + 1);
                            *row += &length;
                        }
                    });
                },
                "lengths.csv line 104: all 51 readings of run `c` from station `S3` equal \
             those from station `S1` (line 2) to the last digit … put in what was measured \
             from `S3`",
            ),
        ],
    );
}

#[test]
fn rows_that_were_sorted() {
    assert_refused(
        &three_axes(),
        &[
            // By target and point.
            (
                |f| {
                    sort(
                        f,
                        "lengths.csv",
                        &["target", "run", "X", "Y", "Z", "station"],
                    );
                },
                "column time_s: the rows are not in measuring order: the time goes back … \
                 would be 120 stops in 4 occupations … sort the table by time_s",
            ),
            // By point, the stops whole.
            (
                |f| {
                    sort(
                        f,
                        "lengths.csv",
                        &["run", "X", "Y", "Z", "direction", "station", "time_s"],
                    );
                },
                "would be 120 stops in 4 occupations … not 120 stops in 120 occupations",
            ),
            // One row put at the end.
            (
                |f| {
                    f.lines("lengths.csv", |lines| {
                        let row = lines.remove(16);
                        lines.push(row);
                    });
                },
                "lengths.csv line 361, column time_s … the time goes back once, here from \
                 897.5 s to 37.5 s",
            ),
        ],
    );
    assert_refused(
        &table_points(),
        &[(
            |f| sort(f, "points.csv", &["target", "time_s"]),
            "points.csv line 19, column time_s … would be 17 stops in 1 occupation of \
             stations",
        )],
    );
}

/// The balls of a bar are nowhere else than its length apart.
#[test]
fn a_bar_keeps_its_length() {
    assert_refused(
        &rotary_table(),
        &[(
            |f| {
                f.replace(
                    "campaign.json",
                    "\"center_mm\": [0, 0, 59.2]",
                    "\"center_mm\": [30, 0, 59.2]",
                );
            },
            "dbb_a.csv line 3: the balls nominally 169.277 mm apart, 126.859 mm in line 2; expected a bar that keeps its \
             length; check ball_mm … where both balls move",
        )],
    );
}

/// A ball that stands still while other axes move keeps its distance, too.
#[test]
fn an_axis_that_moves_carries_the_ball() {
    assert_refused(
        &three_axes(),
        &[(
            |f| {
                f.json(
                    "\"kind\": \"positioning\", \"axis\": \"X\", \"target_mm\": [175.6, 497.5, 312.1]",
                    "\"kind\": \"ballbar\", \"ball_mm\": [150, 0, 0], \"ball_carried_by\": \"X\", \"center_mm\": [0, 0, 0]",
                );
                f.0.insert(
                    "li_x.csv".to_owned(),
                    "cycle,direction,X,Y,Z,delta_um\n1,1,0,0,0,0\n1,1,0,9,1,0\n".to_owned(),
                );
            },
            "li_x.csv line 3: verification `LI along X` is of axis X, but X never moves in it, only Y, Z; correct the axis of \
             the verification (`ball_carried_by` of a ball bar)",
        )],
    );
}

/// A table without times that was sorted by target goes on as it stands; a single target is read alone.
#[test]
fn stops_of_one_target_are_said() {
    let mut files = three_axes();
    sort(&mut files, "lengths.csv", &["station", "target", "time_s"]);
    files.lines("lengths.csv", |lines| {
        for (time_s, line) in lines.iter_mut().enumerate().skip(1) {
            let behind = line.find(',').unwrap();
            line.replace_range(..behind, &time_s.to_string());
        }
    });
    let said = notices(&files);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains(
        "lengths.csv: most stops have one target, though several are read at one position"
    ));
    files.lines("lengths.csv", |lines| {
        lines.retain(|line| !line.contains(",Q,") && !line.contains(",K,"));
    });
    let said = notices(&files);
    assert!(
        said.iter().all(|notice| !notice.contains("one target")),
        "{said:?}"
    );
}

/// A clock that begins again at each station is no sorted table.
#[test]
fn a_clock_that_was_reset_is_a_notice() {
    let mut files = three_axes();
    files.column("lengths.csv", "time_s", |cell, _| {
        (cell.parse::<f64>().unwrap() % 225.0).to_string()
    });
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(said[0].contains("lengths.csv line 92, column time_s: the time goes back"));
}

#[test]
fn times_that_are_no_seconds() {
    assert_refused(
        &three_axes(),
        &[
            (
                |f| f.cell("lengths.csv", 17, "time_s", "09:30:05"),
                "lengths.csv line 17, column time_s: \"09:30:05\" is a time of day … \
                 seconds since the start of the campaign: as hours, minutes and seconds it \
                 is 34205",
            ),
            (
                |f| f.cell("lengths.csv", 2, "time_s", "2026-03-31 09:30:05"),
                "lengths.csv line 2, column time_s: \"2026-03-31 09:30:05\" is a date … \
                 subtract the date and time of the first row",
            ),
        ],
    );
    assert_refused(
        &rotary_table(),
        &[(
            |f| f.cell("dbb_a.csv", 3, "time_s", "0:10"),
            "dbb_a.csv line 3, column time_s: \"0:10\" is a time of day",
        )],
    );
    let mut files = three_axes();
    files.scale("lengths.csv", "time_s", 1.0 / 86_400.0);
    let said = notices(&files);
    assert_eq!(said.len(), 1);
    assert!(
        said[0].starts_with("lengths.csv, column time_s: 360 readings within 0.010 s"),
        "{said:?}"
    );
}

#[test]
fn known_dead_paths_leave_distances_positive() {
    assert_refused(
        &three_axes(),
        &[
            // A dead path of the other sign.
            (
                |f| {
                    let place = "\"approx_mm\": [1500, -800, 300]";
                    let known = "\"dead_path_mm\": -1234.568, \"dead_path_sigma_mm\": 0.01";
                    f.json(place, &format!("{place}, {known}"));
                },
                "lengths.csv line 2, column length_mm … with the dead path of station `S1` \
             (-1234.568 mm) … correct its sign or unit",
            ),
        ],
    );
}

#[test]
fn points_under_each_others_names_are_said() {
    let mut files = table_points();
    files.lines("points.csv", |lines| {
        for line in &mut lines[10..22] {
            *line = match line.contains(",P,") {
                true => line.replace(",P,", ",K,"),
                false => line.replace(",K,", ",P,"),
            };
        }
    });
    let said = notices(&files);
    assert_eq!(said.len(), 1, "{said:?}");
    let expected =
        "points.csv lines 11 to 22: targets `P` and `K` have each other's names at 4 of 17 stops";
    assert!(said[0].starts_with(expected), "{said:?}");
}
