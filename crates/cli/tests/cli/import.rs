//! Exports of trackers, and the beginning of a campaign.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::program::{file_names, run, shipped};

const USAGE: i32 = 2;
const INPUT: i32 = 3;

fn docs() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs"))
}

/// `docs/import.md`, word for word: its commands run, its map is the file it names, it prints what is printed.
#[test]
fn the_five_minutes_of_the_documentation() {
    let page = fs::read_to_string(docs().join("import.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for file in ["turntable.txt", "turntable.toml"] {
        fs::copy(docs().join("examples").join(file), folder.path().join(file)).unwrap();
    }
    let mut said = String::new();
    let mut commands = 0;
    for command in page
        .lines()
        .filter_map(|line| line.trim().strip_prefix("trueaxis "))
    {
        let args: Vec<&str> = command.split(' ').collect();
        let outcome = run(folder.path(), &args);
        outcome.assert_good();
        said += &outcome.stderr;
        commands += 1;
    }
    assert_eq!(commands, 4);
    let blocks = page.split("```").skip(1).step_by(2);
    let blocks: Vec<String> = blocks
        .map(|block| {
            block
                .lines()
                .skip(1)
                .map(|line| format!("{}\n", line.strip_prefix("   ").unwrap_or(line)))
                .collect()
        })
        .collect();
    let export = fs::read_to_string(docs().join("examples/turntable.txt")).unwrap();
    let export = export.replace('\r', "");
    let map = fs::read_to_string(docs().join("examples/turntable.toml")).unwrap();
    assert_eq!(export.lines().count(), 30);
    assert!(export.starts_with(&blocks[0]));
    assert!(blocks[2].starts_with(&map), "{}", blocks[2]);
    let printed = blocks[4].trim_end();
    assert!(said.contains(printed), "no\n{printed}\nin\n{said}");
    let report = fs::metadata(folder.path().join("result/report.html")).unwrap();
    assert!(report.len() > 10_000);
}

/// Each starting campaign is good once its template holds readings.
#[test]
fn a_template_that_is_filled_in_can_be_calibrated() {
    for (machine, shipped_as) in [
        ("fxyz", "fxyz"),
        ("five-axis", "five-axis"),
        ("rotary-stage", "rotary-stage"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        run(folder.path(), &["init", "new", "--type", machine]).assert_good();
        let new = folder.path().join("new");
        let lengths = fs::read_to_string(shipped(shipped_as).join("lengths.csv")).unwrap();
        let rows: Vec<(&str, &str, &str)> = lengths
            .lines()
            .filter_map(|row| {
                let (time_s, rest) = row.split_once(',')?;
                let (visit, length) = rest.rsplit_once(',')?;
                Some((time_s, visit, length))
            })
            .collect();
        let template = fs::read_to_string(new.join("lengths-template.csv")).unwrap();
        let mut filled = template.lines().next().unwrap().to_owned() + "\n";
        for row in template.lines().skip(1) {
            let visit = row.trim_start_matches(',').strip_suffix(',').unwrap();
            let (time_s, _, length) = rows.iter().find(|row| row.1 == visit).unwrap();
            filled += &format!("{time_s},{visit},{length}\n");
        }
        fs::write(new.join("lengths.csv"), filled).unwrap();
        run(folder.path(), &["check", "new/campaign.json"]).assert_good();
        let calibrate = [
            "calibrate",
            "new/campaign.json",
            "--out",
            "result",
            "--no-report",
        ];
        run(folder.path(), &calibrate).assert_good();
    }
}

/// The cells of each row but times and readings, by the names of their columns.
fn visits(table: &str) -> Vec<BTreeMap<&str, &str>> {
    let mut rows = table.lines().map(|row| row.split(','));
    let names: Vec<&str> = rows.next().unwrap().collect();
    let is_visit = |name: &str| !name.ends_with("_mm") && name != "time_s";
    rows.map(|cells| {
        names
            .iter()
            .copied()
            .zip(cells)
            .filter(|(name, _)| is_visit(name))
            .collect()
    })
    .collect()
}

/// The map of each starting campaign makes the visits of its template of an export in their order.
#[test]
fn the_map_of_a_starting_campaign_fits_its_path() {
    for (machine, rows) in [("fxyz", 195), ("five-axis", 342), ("rotary-stage", 57)] {
        for (kind, points, stations) in [("points", true, 1), ("lengths", false, 4)] {
            let folder = tempfile::tempdir().unwrap();
            let mut init = vec!["init", "new", "--type", machine];
            init.extend(points.then_some("--points"));
            run(folder.path(), &init).assert_good();
            let template = folder.path().join(format!("new/{kind}-template.csv"));
            let template = fs::read_to_string(template).unwrap();
            let planned = visits(&template);
            assert_eq!(planned.len(), 2 * stations * rows, "{machine} {kind}");
            let export = planned.iter().enumerate().map(|(number, visit)| {
                let station = visit.get("station").unwrap_or(&"");
                format!("{number},{station},{},1,2,3,4\n", visit["target"])
            });
            let names = "Time,Station,Point,Distance,X,Y,Z\n".to_owned();
            let export = names + &export.collect::<String>();
            fs::write(folder.path().join("export.txt"), export).unwrap();
            let args = [
                "import",
                kind,
                "export.txt",
                "--map",
                "new/import.toml",
                "--out",
                "out.csv",
            ];
            run(folder.path(), &args).assert_good();
            let table = fs::read_to_string(folder.path().join("out.csv")).unwrap();
            assert_eq!(visits(&table), planned, "{machine} {kind}");
        }
    }
}

/// Nothing is overwritten, and nothing is left where something is wrong.
#[test]
fn nothing_is_overwritten_or_left_half_done() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["turntable.txt", "turntable.toml"] {
        fs::copy(docs().join("examples").join(file), folder.path().join(file)).unwrap();
    }
    let import = [
        "import",
        "points",
        "turntable.txt",
        "--map",
        "turntable.toml",
        "--out",
    ];
    let to = |out: &'static str| [import.as_slice(), &[out]].concat();
    let there = "is there already and is not overwritten";
    run(folder.path(), &to("turntable.txt")).assert_failed(
        "itself",
        USAGE,
        &format!("turntable.txt … {there}"),
    );
    run(
        folder.path(),
        &[
            "import",
            "lengths",
            "turntable.txt",
            "--map",
            "turntable.toml",
        ],
    )
    .assert_failed(
        "lengths",
        INPUT,
        "nothing says the length_mm … add length_mm =",
    );
    run(
        folder.path(),
        &["import", "points", "none.txt", "--map", "turntable.toml"],
    )
    .assert_failed("no file", INPUT, "none.txt … no such file");
    run(
        folder.path(),
        &["import", "points", "turntable.txt", "--map", "."],
    )
    .assert_failed("folder", INPUT, "this is a folder");
    assert_eq!(
        file_names(folder.path()),
        ["turntable.toml", "turntable.txt"]
    );

    run(folder.path(), &["init", "turntable.txt"]).assert_failed(
        "file",
        USAGE,
        "cannot be written",
    );
    let outcome = run(folder.path(), &["init", "a new one"]);
    outcome.assert_good();
    let says = "check \"a new one/campaign.json\"\n";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
    // The campaign is what matters; without it the template.
    run(folder.path(), &["init", "new"]).assert_good();
    let again = run(folder.path(), &["init", "new", "--type", "rotary-stage"]);
    again.assert_failed("again", USAGE, &format!("new/campaign.json … {there}"));
    fs::remove_file(folder.path().join("new/campaign.json")).unwrap();
    let again = run(folder.path(), &["init", "new", "--type", "rotary-stage"]);
    again.assert_failed(
        "again",
        USAGE,
        &format!("new/lengths-template.csv … {there}"),
    );
    assert!(!folder.path().join("new/campaign.json").exists());
}
