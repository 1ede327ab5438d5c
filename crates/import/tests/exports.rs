//! Exports as programs of trackers write them, and what is said of maps and rows that are wrong.

use trueaxis_import::{Error, Imported, Kind, Map, import};

fn imported(kind: Kind, map: &str, text: &str) -> Result<Imported, Error> {
    let map = Map::parse(map, Some("map.toml".as_ref()))?;
    import(kind, text.as_bytes(), Some("export.txt".as_ref()), &map)
}

const COORDINATES: &str = r#"
x_mm = { column = "X", unit = "mm" }
y_mm = { column = "Y", unit = "mm" }
z_mm = { column = "Z", unit = "mm" }
"#;

/// A point list with names of points that tell target and position, footers, decimal commas and inches.
#[test]
fn names_of_points_tell_target_and_position() {
    let map = r#"
        separator = "tab"
        decimal = ","
        skip_lines = 2
        comment = ["//", "Total"]
        skip_rows = ["---"]
        [columns]
        run = { value = "x" }
        time_s = { column = "Time", unit = "clock" }
        x_mm = { column = "X [in]", unit = "in" }
        y_mm = { column = "Y [in]", unit = "in" }
        z_mm = { column = "Z [in]", unit = "in" }
        sigma_um = { column = "RMS", unit = "in" }
        [axes]
        X = { unit = "in" }
        Y = { value = 0, unit = "mm" }
        [[split]]
        column = "Point"
        pattern = "{target}_{X}"
        [rename]
        SMR1 = "P"
    "#;
    let text = "Project: bench\r\n\r\n// a remark\r\nPoint\tTime\tX [in]\tY [in]\tZ [in]\tRMS\r\n\
        SMR1_0,0\t23:59:59,5\t1,0\t0\t-2,5\t0,0001\r\n\
        Q_0,0\t00:00:01\t1,2345\t0\t0\t\r\n\
        \r\n\
        SMR1_10,0\t00:00:09\t---\t---\t---\t---\r\n\
        Q_10,0\t00:00:11\t11,0\t0\t0\t0,0002\r\n\
        Total: 4 points\r\n";
    let imported = imported(Kind::Points, map, text).unwrap();
    assert_eq!(
        imported.text(),
        "time_s,repeat,run,direction,X,Y,target,x_mm,y_mm,z_mm,sigma_um\n\
         0,1,x,1,0,0,P,25.4,0,-63.5,2.54\n\
         1.5,1,x,1,0,0,Q,31.3563,0,0,\n\
         11.5,1,x,1,254,0,Q,279.4,0,0,5.08\n"
    );
    let skipped: Vec<(usize, &str)> = imported
        .skipped
        .iter()
        .map(|s| (s.line, s.reason.as_str()))
        .collect();
    assert_eq!(
        skipped,
        [
            (1, "before the table (skip_lines)"),
            (2, "before the table (skip_lines)"),
            (3, "comment (//)"),
            (4, "names of the columns"),
            (7, "blank"),
            (8, "a cell is \"---\" (skip_rows)"),
            (10, "comment (Total)"),
        ]
    );
}

/// Neither targets nor positions are in the file: they follow from the order of the rows, at each station anew.
#[test]
fn the_order_of_the_rows_tells_target_and_position() {
    let map = r#"
        separator = "blanks"
        column_names = false
        [columns]
        station = { column = 1 }
        length_mm = { column = 2, unit = "m" }
        air_temp_c = { column = 3 }
        [axes]
        X = { unit = "mm" }
        C = { unit = "deg" }
        [stops]
        targets = ["P", "Q"]
        path = [{ run = "x", axis = "X", from = 0, to = 20, step = 20, back = true, at = { C = 90 } }]
    "#;
    let stations = ["S1", "S2"].map(|station| {
        (0..16)
            .map(|row| format!("  {station}\t0.{row:02}  20.5\n"))
            .collect::<String>()
    });
    let imported = imported(Kind::Lengths, map, &stations.concat()).unwrap();
    assert_eq!(imported.stops, 16);
    assert_eq!(
        imported.header.join(","),
        "time_s,station,repeat,run,direction,C,X,target,length_mm,air_temp_c"
    );
    let rows: Vec<String> = imported.rows.iter().map(|row| row.join(",")).collect();
    assert_eq!(
        [&rows[0], &rows[3], &rows[5], &rows[7], &rows[8], &rows[16]],
        [
            "0,S1,1,x,1,90,0,P,0,20.5",
            "3,S1,1,x,1,90,20,Q,30,20.5",
            "5,S1,1,x,-1,90,20,Q,50,20.5",
            "7,S1,1,x,-1,90,0,Q,70,20.5",
            "8,S1,2,x,1,90,0,P,80,20.5",
            "16,S2,1,x,1,90,0,P,0,20.5",
        ]
    );
}

/// A target that was not read at a stop does not shift the stops behind it.
#[test]
fn a_missing_reading_stays_alone() {
    let map = format!(
        "[columns]\ntarget = {{ column = \"T\" }}{COORDINATES}\
         [axes]\nC = {{ unit = \"deg\" }}\n[stops]\ntargets = [\"P\", \"Q\", \"K\"]\n\
         path = [{{ run = \"c\", axis = \"C\", positions = [0, 90, 180] }}]"
    );
    let text = |targets: &str| {
        let rows = targets.chars().map(|target| format!("{target},1,2,3\n"));
        format!("T,X,Y,Z\n{}", rows.collect::<String>())
    };
    let imported = imported(Kind::Points, &map, &text("PQKQKPQK")).unwrap();
    let positions: Vec<&str> = imported.rows.iter().map(|row| row[4].as_str()).collect();
    assert_eq!(positions, ["0", "0", "0", "90", "90", "180", "180", "180"]);
}

/// Runs of different targets follow each other, at one position of all axes.
#[test]
fn each_run_has_its_targets() {
    let map = format!(
        "[columns]\ntarget = {{ column = \"T\" }}{COORDINATES}\
         [axes]\nX = {{ unit = \"mm\" }}\nC = {{ unit = \"deg\" }}\n[stops]\npath = [\
         {{ run = \"x\", axis = \"X\", positions = [0, 10], targets = [\"P\", \"Q\"] }},\
         {{ run = \"c\", axis = \"C\", positions = [0, 90], targets = [\"U\"] }}]"
    );
    let rows = "PQPQUUPQPQUU"
        .chars()
        .map(|target| format!("{target},1,2,3\n"));
    let text = format!("T,X,Y,Z\n{}", rows.collect::<String>());
    for map in [map.clone(), map.replace("target = { column = \"T\" }", "")] {
        let imported = imported(Kind::Points, &map, &text).unwrap();
        let visits = imported
            .rows
            .iter()
            .map(|row| [&row[1..3], &row[4..7]].concat().join(" "));
        let visits: Vec<String> = visits.collect();
        assert_eq!(
            visits[..6],
            [
                "1 x 0 0 P",
                "1 x 0 0 Q",
                "1 x 0 10 P",
                "1 x 0 10 Q",
                "1 c 0 0 U",
                "1 c 90 0 U"
            ]
        );
        assert_eq!(visits[11], "2 c 90 0 U");
    }
}

/// Columns that are there: direction and repeat follow from the motion.
#[test]
fn direction_and_repeat_follow_from_the_positions() {
    let map = format!(
        "[columns]\nrun = {{ value = \"x\" }}\ntarget = {{ column = \"T\" }}{COORDINATES}\
         [axes]\nX = {{ column = \"pos\", unit = \"mm\" }}"
    );
    let rows = [0, 10, 10, 0, 0, 10].map(|pos| format!("P,{pos},1,2,3\nQ,{pos},1,2,3\n"));
    let imported = imported(
        Kind::Points,
        &map,
        &format!("T,pos,X,Y,Z\n{}", rows.concat()),
    )
    .unwrap();
    let visits = imported
        .rows
        .iter()
        .step_by(2)
        .map(|row| row[1..5].join(" "));
    assert_eq!(
        visits.collect::<Vec<_>>(),
        [
            "1 x 1 0",
            "1 x 1 10",
            "1 x -1 10",
            "1 x -1 0",
            "2 x 1 0",
            "2 x 1 10"
        ]
    );
}

/// A stop that is missing is found where a target does not belong to the stop that is next in the path; it once shifted the
/// stops behind it, since the target began a stop of its own and the count of stops was right again.
#[test]
fn a_missing_stop_does_not_shift_the_path() {
    let map = format!(
        "[columns]\ntarget = {{ column = \"T\" }}{COORDINATES}\
         [axes]\nX = {{ unit = \"mm\" }}\nC = {{ unit = \"deg\" }}\n[stops]\npath = [\
         {{ run = \"x\", axis = \"X\", positions = [0, 10], targets = [\"P\", \"Q\"] }},\
         {{ run = \"c\", axis = \"C\", positions = [0, 90], targets = [\"U\", \"V\"] }}]"
    );
    let rows = "PQUVUV".chars().map(|target| format!("{target},1,2,3\n"));
    let text = format!("T,X,Y,Z\n{}", rows.collect::<String>());
    let error = imported(Kind::Points, &map, &text).unwrap_err().to_string();
    let says = "line 4: target `U` is read where the path has run `x` at X 10 with P, Q; a stop above is missing";
    assert!(error.contains(says), "{error}");
}

/// Rows with their times of day, over midnight, in the order of measuring and sorted by target.
#[test]
fn sorted_rows_are_no_repeats() {
    let map = |time: &str| {
        format!(
            "[columns]\nrun = {{ value = \"x\" }}\ntime_s = {{ column = \"time\", unit = \"{time}\" }}\n\
             target = {{ column = \"T\" }}{COORDINATES}[axes]\nX = {{ column = \"pos\", unit = \"mm\" }}"
        )
    };
    let by_clock = [(0, "23:59:57"), (10, "23:59:59"), (20, "0:0:1")]
        .map(|(pos, time)| ["P", "Q"].map(|target| format!("{time},{target},{pos},1,2,3\n")));
    let by_seconds = [0, 10, 20].map(|pos| {
        [(0, "P"), (1, "Q")].map(|(s, target)| format!("{},{target},{pos},1,2,3\n", pos + s))
    });
    for (unit, rows) in [("clock", by_clock), ("s", by_seconds)] {
        let text = |rows: Vec<&String>| {
            let rows: String = rows.into_iter().map(String::as_str).collect();
            format!("time,T,pos,X,Y,Z\n{rows}")
        };
        let measured = text(rows.iter().flatten().collect());
        assert_eq!(
            imported(Kind::Points, &map(unit), &measured).unwrap().stops,
            3
        );
        let sorted = text(
            [0, 1]
                .iter()
                .flat_map(|&t| rows.iter().map(move |r| &r[t]))
                .collect(),
        );
        let error = imported(Kind::Points, &map(unit), &sorted)
            .unwrap_err()
            .to_string();
        let says = "line 5: the rows are not in measuring order: the time goes back here, and in the order of time they \
                    would be 3 stops, not 6; sort the export by time";
        assert!(error.contains(says), "{unit}: {error}");
    }
}

/// A spreadsheet ends the table with lines of separators, an old one its lines with CR, and rows are copied by mistake.
#[test]
fn what_spreadsheets_leave_behind() {
    let map = format!(
        "[columns]\nrun = {{ value = \"x\" }}\ntime_s = {{ column = \"time\", unit = \"s\" }}\n\
         target = {{ column = \"T\" }}{COORDINATES}[axes]\nX = {{ column = \"pos\", unit = \"mm\" }}"
    );
    let text = "time,T,pos,X,Y,Z\r0,P,0,1,2,3\r0,P,0,1,2,3\r1,P,9,1,2,3\r, ,,\r\"\",\"\"\r";
    let imported = imported(Kind::Points, &map, text).unwrap();
    assert_eq!((imported.rows.len(), imported.stops), (2, 2));
    let reasons = imported.skipped.iter().map(|s| (s.line, s.reason.as_str()));
    let expected = [
        (1, "names of the columns"),
        (3, "a copy of a row above"),
        (5, "blank"),
        (6, "blank"),
    ];
    assert_eq!(reasons.collect::<Vec<_>>(), expected);
}

/// Each mistake that a newcomer makes is said with its place and how to correct it.
#[test]
fn mistakes_are_explained() {
    let good = format!(
        "[columns]\nrun = {{ value = \"x\" }}\ntarget = {{ column = \"T\" }}{COORDINATES}[axes]\n\
         X = {{ column = \"pos\", unit = \"mm\" }}\n"
    );
    let text = "T,pos,X,Y,Z\nP,0,1,2,3\n";
    imported(Kind::Points, &good, text).unwrap();
    let map = |from: &str, to: &str| good.replacen(from, to, 1);
    for (map, text, says) in [
        (
            map("[axes]", "[axis]"),
            text,
            "map.toml line 7: unknown field `axis`; did you mean `axes`?",
        ),
        (
            map("\"X\", unit", "\"X\" unit"),
            text,
            "map.toml line 4: not valid TOML",
        ),
        (
            map("\"X\", unit = \"mm\"", "\"X\""),
            text,
            "map.toml line 4, field columns.x_mm: the unit is not stated; expected unit = \"…\", one of mm, um, cm",
        ),
        (
            map("unit = \"mm\"", "unit = \"inchs\""),
            text,
            "unknown unit `inchs`; did you mean `in",
        ),
        (
            map("unit = \"mm\"", "unit = \"deg\""),
            text,
            "unknown unit `deg`",
        ),
        (
            map("column = \"T\"", "column = \"Target\""),
            text,
            "map.toml line 3, field columns.target: the export has no column `Target` in its line 1 of names; known: T",
        ),
        (
            map("y_mm", "ymm"),
            text,
            "unknown column of the table `ymm`; did you mean `y_mm`?",
        ),
        (
            map("z_mm = { column = \"Z\", unit = \"mm\" }", ""),
            text,
            "nothing says the z_mm of a row; add",
        ),
        (
            map("run = { value = \"x\" }", ""),
            text,
            "nothing says the run of a row; add run = {",
        ),
        (
            map("column = \"pos\", ", ""),
            text,
            "field axes.X: nothing tells where it stands",
        ),
        (
            map("[columns]", "separator = \";\"\n[columns]"),
            text,
            "is the separator a semicolon",
        ),
        (
            map("[columns]", "decimal = \",\"\n[columns]"),
            text,
            "a comma is both",
        ),
        (
            map("[columns]", "column_names = false\n[columns]"),
            text,
            "columns have only numbers",
        ),
        (
            good.clone(),
            "T,pos,X,Y,Z\nP,0,1,2\nP,1,1,2\n",
            "export.txt line 2: found 4 cells, but the map needs 5",
        ),
        (
            good.clone(),
            "T,pos,X,Y,Z\nP,0,1,2,3\nP,0,,2,3\n",
            "export.txt line 3, column X: found \"\"; expected a number",
        ),
        (
            map("[columns]", "separator = \";\"\n[columns]"),
            "T;pos;X;Y;Z\nP;0;1,5;2;3\nP;0;1,5;2;3\n",
            "found \"1,5\"; expected a number with \".\" as decimal sign; decimal = \",\" in the map changes it (and 1 more row)",
        ),
        (
            good.clone(),
            "T,pos,X,Y,Z\n",
            "no rows are left: 1 lines were read, 1 skipped",
        ),
        (good.clone(), "PK\u{3}\0\0", "this is not text"),
        (
            format!("{good}[stops]\ntargets = [\"Q\"]"),
            text,
            "line 2, column T: found \"P\"; expected one of Q (targets)",
        ),
        (
            map("target = { column = \"T\" }", "") + "[stops]\ntargets = [\"P\", \"Q\"]",
            text,
            "line 2: the stop that begins here has 1 row, expected 2 (P, Q)",
        ),
        (
            map("column = \"pos\", ", "")
                + "[stops]\npath = [{ run = \"x\", axis = \"X\", positions = [1, 2] }]",
            text,
            "line 2: the export has 1 stop, a round of the path has 2; 1 too many or 1 too few",
        ),
        (
            format!(
                "{good}[stops]\npath = [{{ run = \"x\", axis = \"X\", from = 0, to = 45, step = 20 }}]"
            ),
            text,
            "field stops.path[0]: from 0 to 45 are 2.250 steps of 20",
        ),
        (
            format!("{good}[stops]\npath = [{{ run = \"x\", axis = \"W\", positions = [0] }}]"),
            text,
            "unknown axis `W`",
        ),
        (
            format!("{good}[[split]]\ncolumn = \"T\"\npattern = \"{{target}}{{X}}\""),
            text,
            "nothing stands between two fields",
        ),
    ] {
        let error = imported(Kind::Points, &map, text).unwrap_err().to_string();
        assert!(error.contains(says), "no `{says}` in: {error}");
    }
}

/// Damaged bytes of export and map are read or refused, never more.
#[test]
fn nothing_panics() {
    let docs = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/examples/turntable");
    let [export, map] = ["txt", "toml"].map(|end| std::fs::read(format!("{docs}.{end}")).unwrap());
    let signs = b"\",;.\n\r\t {}[]=_0-\xFF\xC3";
    let mut state = 1_u64;
    let mut draw = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        usize::try_from(state >> 33).unwrap() % below
    };
    let (mut read, mut refused) = (0, 0);
    for round in 0..4000 {
        let (mut export, mut map) = (export.clone(), map.clone());
        let damaged = if round % 2 == 0 {
            &mut export
        } else {
            &mut map
        };
        for _ in 0..1 + draw(3) {
            let at = draw(damaged.len());
            match draw(3) {
                0 => damaged[at] = signs[draw(signs.len())],
                1 => drop(damaged.drain(at..damaged.len().min(at + draw(20)))),
                _ => damaged.truncate(at.max(1)),
            }
        }
        let map = Map::parse(&String::from_utf8_lossy(&map), None);
        match map.and_then(|map| import(Kind::Points, &export, None, &map)) {
            Ok(_) => read += 1,
            Err(_) => refused += 1,
        }
    }
    // Both happen.
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
}
