//! `trueaxis check` of what is right.

use crate::campaign_files::CampaignFiles;
use crate::program::{file_names, run, shipped};

#[test]
fn says_what_is_in_the_shipped_campaigns() {
    let folder = tempfile::tempdir().unwrap();
    for (campaign, says) in [
        (
            "rotary-stage",
            &[
                "bed to workpiece: C (rotary)",
                "684 in 228 stops",
                "19 steps",
            ][..],
        ),
        (
            "fxyz",
            &[
                "bed to tool: X (linear), Y (linear), Z (linear)",
                "stations  S1, S2, S3, S4",
                "run       x: axis X, 23 steps",
                "  coverage  run  targets   S1   S2   S3   S4\n            \
                 x    P Q K    69   69   69   69\n",
            ],
        ),
        ("five-axis", &["U on C", "run       a: axis A, 11 steps"]),
    ] {
        let path = shipped(campaign).join("campaign.json");
        let outcome = run(folder.path(), &["check", path.to_str().unwrap()]);
        outcome.assert_good();
        assert_eq!(outcome.stdout, "");
        assert!(outcome.stderr.ends_with("campaign.json: good\n"));
        assert!(!outcome.stderr.contains("notice"), "{}", outcome.stderr);
        for part in says {
            assert!(outcome.stderr.contains(part), "{part}: {}", outcome.stderr);
        }
    }
    assert!(file_names(folder.path()).is_empty());
}

#[test]
fn holes_are_marked_in_the_table_and_in_json() {
    let mut files = CampaignFiles::shipped("fxyz");
    files.keep(|row| {
        let one = [
            ("station", "S1"),
            ("repeat", "2"),
            ("X", "200"),
            ("target", "Q"),
        ];
        let step = [
            ("station", "S2"),
            ("run", "x"),
            ("X", "200"),
            ("target", "Q"),
        ];
        let run = [("station", "S4"), ("run", "y"), ("target", "K")];
        !row.is(&one) && !row.is(&step) && !row.is(&run)
    });
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(folder.path(), &["check", "campaign.json", "--json"]);
    outcome.assert_good();
    for line in [
        "x    P K      69   69   69   69\n",
        "x    Q        68*  66!  69   69\n",
        "y    P Q      63   63   63   63\n",
        "y    K        63   63   63    –\n",
        "            – never seen from there; ! some steps never seen from there; * fewer",
    ] {
        assert!(outcome.stderr.contains(line), "{line}: {}", outcome.stderr);
    }
    assert!(!outcome.stderr.contains("notice"), "{}", outcome.stderr);
    let json: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(json["format"], "trueaxis-check");
    let coverage = json["coverage"].as_array().unwrap();
    assert_eq!(coverage.len(), 3 * 3 * 4);
    let entry = |run: &str, target: &str, station: &str| {
        let is = |e: &&serde_json::Value| {
            e["run"] == run && e["target"] == target && e["station"] == station
        };
        let entry = coverage.iter().find(is).unwrap();
        (entry["readings"].as_u64().unwrap(), entry["hole"].clone())
    };
    assert_eq!(entry("x", "Q", "S1"), (68, "readings".into()));
    assert_eq!(entry("x", "Q", "S2"), (66, "steps".into()));
    assert_eq!(entry("y", "K", "S4"), (0, "not seen".into()));
    assert_eq!(entry("z", "P", "S3"), (63, serde_json::Value::Null));
}

#[test]
fn a_wide_table_goes_on_below() {
    let files = CampaignFiles::simulated("rotary-stage", |scenario| {
        let stations = scenario["stations"].as_array_mut().unwrap();
        for i in 5..=30 {
            let mut station = stations[i % 4].clone();
            station["name"] = format!("S{i}").into();
            station["position_mm"][2] = (100 * i).into();
            stations.push(station);
        }
    });
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(folder.path(), &["check", "campaign.json"]);
    outcome.assert_good();
    let table = outcome.stderr.split("  coverage").nth(1).unwrap();
    let lines: Vec<&str> = table
        .lines()
        .take_while(|line| !line.contains("campaign.json"))
        .collect();
    assert_eq!(lines.len(), 2 * 2, "{table}");
    assert!(lines.iter().all(|line| line.len() <= 100), "{table}");
    assert!(lines[2].starts_with("            run  targets"), "{table}");
    assert!(lines[2].ends_with("S30"), "{table}");
    let counts = table.matches("57").count();
    assert_eq!(counts, 30, "{table}");
}

/// What can be read but not calibrated is said before the whole machine is measured like that.
#[test]
fn says_what_a_calibration_lacks() {
    let mut files = CampaignFiles::shipped("fxyz");
    files.keep(|row| {
        let is_of_x = row.is(&[("run", "x")]);
        let is_kept = row.is(&[("X", "0")]) || row.is(&[("X", "20")]);
        !row.is(&[("station", "S4")])
            && (!is_of_x || is_kept)
            && !(row.is(&[("run", "y"), ("target", "K")]))
    });
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(folder.path(), &["check", "campaign.json"]);
    outcome.assert_good();
    for says in [
        "lengths from 3 stations: a calibration needs 4",
        "run y: targets P, Q are fewer than three or on one line",
        "axis X: measured at 2 positions",
        "can be read; see the 4 notices above",
    ] {
        assert!(outcome.stderr.contains(says), "{says}: {}", outcome.stderr);
    }
}

/// What encoders show is no command, and of it every reading is a position of its own.
#[test]
fn says_where_positions_are_those_of_encoders() {
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(shipped("fxyz-lines")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let outcome = run(folder.path(), &["check", "campaign.json"]);
    assert!(!outcome.stderr.contains("encoders"), "{}", outcome.stderr);
    let path = folder.path().join("verification_1.csv");
    let table = std::fs::read_to_string(&path).unwrap();
    let mut lines = table.lines();
    let header = lines.next().unwrap();
    let column = header.split(',').position(|name| name == "X").unwrap();
    let shown = lines.enumerate().map(|(row, line)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let x: f64 = cells[column].parse().unwrap();
        cells[column] = format!("{:.4}", x + 1e-4 * (row % 11) as f64);
        cells.join(",")
    });
    let shown: Vec<String> = std::iter::once(header.to_owned()).chain(shown).collect();
    std::fs::write(&path, shown.join("\n") + "\n").unwrap();
    let outcome = run(folder.path(), &["check", "campaign.json"]);
    outcome.assert_good();
    let says = "LI along X: most positions are nearly alike, but not the same";
    assert!(outcome.stderr.contains(says), "{}", outcome.stderr);
}
