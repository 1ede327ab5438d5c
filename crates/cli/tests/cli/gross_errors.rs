//! Lengths that contradict the others are removed and said; the results are those without them.

use std::fs;

use serde_json::Value;

use crate::campaign_files::CampaignFiles;
use crate::program::{Outcome, run};

fn calibrate(files: &CampaignFiles, options: &[&str]) -> (Outcome, Option<Value>) {
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let mut arguments = vec!["calibrate", "campaign.json", "--out", "out"];
    arguments.extend(options);
    let outcome = run(folder.path(), &arguments);
    let text = fs::read(folder.path().join("out/calibration.json"));
    (
        outcome,
        text.ok().map(|text| serde_json::from_slice(&text).unwrap()),
    )
}

/// A damage and what becomes of it.
struct Damage {
    name: &'static str,
    change: fn(&mut CampaignFiles),
    /// Lines that are removed.
    removed: &'static [u64],
    says: &'static [&'static str],
    /// Exit code if nothing is removed.
    plain_code: i32,
}

const DAMAGES: [Damage; 5] = [
    Damage {
        name: "sign of one length",
        change: |files| files.cell(601, "length_mm", "316.1"),
        removed: &[601],
        says: &[
            "removed: 1 of 2340 lengths",
            "line 601 (station S2, target K",
        ],
        plain_code: 4,
    },
    Damage {
        name: "one length 50 mm off",
        change: |files| shift(files, 9, 50.0),
        removed: &[11],
        says: &["removed: 1 of", "line 11 (station S1"],
        plain_code: 4,
    },
    Damage {
        name: "one length 0.1 mm off",
        change: |files| shift(files, 9, 0.1),
        removed: &[11],
        says: &["removed: 1 of", "run x at X = 60 mm"],
        plain_code: 0,
    },
    Damage {
        name: "one length 10 µm off",
        change: |files| shift(files, 1200, -0.01),
        removed: &[1202],
        says: &["removed: 1 of"],
        plain_code: 0,
    },
    Damage {
        name: "targets exchanged at one stop",
        change: |files| {
            files.exchange("target", ["P", "Q"], |row| {
                row.is(&[
                    ("run", "x"),
                    ("X", "200"),
                    ("station", "S1"),
                    ("repeat", "2"),
                ])
            });
        },
        removed: &[],
        says: &["removed: 2 of"],
        plain_code: 4,
    },
];

fn shift(files: &mut CampaignFiles, row: usize, by_mm: f64) {
    files.table(|table| {
        let cell = table.rows[row].last_mut().unwrap();
        *cell = (cell.parse::<f64>().unwrap() + by_mm).to_string();
    });
}

#[test]
fn removed_and_said() {
    let sound = CampaignFiles::shipped("fxyz");
    let (_, right) = calibrate(&sound, &[]);
    let right = right.unwrap();
    for damage in DAMAGES {
        let name = damage.name;
        let mut files = sound.clone();
        (damage.change)(&mut files);
        let (outcome, found) = calibrate(&files, &[]);
        assert_eq!(outcome.code, Some(0), "{name}: {}", outcome.stderr);
        for part in damage.says {
            assert!(
                outcome.stderr.contains(part),
                "{name}: no `{part}` in: {}",
                outcome.stderr
            );
        }
        let found = found.unwrap();
        let rejected = found["adjustment"]["rejected"].as_array().unwrap();
        for line in damage.removed {
            assert!(
                rejected.iter().any(|r| r["row"] == *line),
                "{name}: {rejected:?}"
            );
        }
        // One or two of the 36 lengths of a step less: its results move by less than their u.
        let change = largest_change_in_u(&right, &found);
        assert!(change < 1.0, "{name}: {change} u");
    }
}

#[test]
fn all_lengths_as_they_are_on_request() {
    let sound = CampaignFiles::shipped("fxyz");
    for damage in DAMAGES {
        let mut files = sound.clone();
        (damage.change)(&mut files);
        let (outcome, found) = calibrate(&files, &["--no-robust"]);
        let name = damage.name;
        assert_eq!(
            outcome.code,
            Some(damage.plain_code),
            "{name}: {}",
            outcome.stderr
        );
        let expected = if damage.plain_code == 0 {
            "the residuals are"
        } else {
            "contradict each other"
        };
        assert!(
            outcome.stderr.contains(expected),
            "{name}: {}",
            outcome.stderr
        );
        if let Some(found) = found {
            assert_eq!(
                found["adjustment"]["rejected"],
                Value::Array(Vec::new()),
                "{name}"
            );
        }
    }
}

/// A lost count in the second station's occupation: said with its size and place, and harmless.
#[test]
fn an_interrupted_beam_is_harmless() {
    let sound = CampaignFiles::shipped("fxyz");
    let (_, right) = calibrate(&sound, &[]);
    let mut files = sound;
    files.table(|table| {
        for row in &mut table.rows[900..1170] {
            let cell = row.last_mut().unwrap();
            *cell = (cell.parse::<f64>().unwrap() + 0.0321).to_string();
        }
    });
    let (outcome, found) = calibrate(&files, &[]);
    outcome.assert_good();
    assert!(
        outcome.stderr.contains("S2: the lengths jump by +32"),
        "{}",
        outcome.stderr
    );
    let found = found.unwrap();
    let occupations = found["adjustment"]["interruptions"].as_array().unwrap();
    assert_eq!(occupations.len(), 1);
    // The first shifted row is line 902 (the header is line 1); the instant is right to a visit.
    let after = occupations[0]["rows"][1].as_u64().unwrap();
    assert!(after.abs_diff(902) <= 3, "{after}");
    let change = occupations[0]["change_um"].as_f64().unwrap();
    assert!(
        (change - 32.1).abs() < 4.0 * occupations[0]["u_um"].as_f64().unwrap(),
        "{change}"
    );
    assert!(largest_change_in_u(&right.unwrap(), &found) < 1.0);
}

/// A tenth of the lengths wrong is no accident: refused, and where they are.
#[test]
fn too_many_are_refused() {
    let mut files = CampaignFiles::shipped("fxyz");
    files.table(|table| {
        for (i, row) in table
            .rows
            .iter_mut()
            .enumerate()
            .filter(|(i, _)| i % 10 == 3)
        {
            let cell = row.last_mut().unwrap();
            let by_mm = [0.05, -0.4, 1.3, -3.0][i / 10 % 4];
            *cell = (cell.parse::<f64>().unwrap() + by_mm).to_string();
        }
    });
    let (outcome, found) = calibrate(&files, &[]);
    assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
    for part in [
        "of 2340 lengths contradict the others",
        "5 %",
        "most of them: station",
        "--no-robust",
    ] {
        assert!(
            outcome.stderr.contains(part),
            "no `{part}` in: {}",
            outcome.stderr
        );
    }
    assert!(found.is_none());
}

/// Largest change of a component error between two results, in its standard uncertainty.
fn largest_change_in_u(before: &Value, after: &Value) -> f64 {
    let mut largest = 0.0_f64;
    for (a, b) in axes(before).iter().zip(axes(after)) {
        let components = a["components"].as_object().unwrap();
        for (name, curve) in components {
            let other = &b["components"][name];
            let unit = if curve.get("value_um").is_some() {
                "um"
            } else {
                "arcsec"
            };
            let of = |curve: &Value, kind: &str| -> Vec<f64> {
                let list = curve[format!("{kind}_{unit}")].as_array().unwrap();
                list.iter().map(|x| x.as_f64().unwrap()).collect()
            };
            let u = of(curve, "u");
            for ((a, b), u) in of(curve, "value").iter().zip(of(other, "value")).zip(u) {
                if u > 0.0 {
                    largest = largest.max((a - b).abs() / u);
                }
            }
        }
    }
    largest
}

fn axes(document: &Value) -> &Vec<Value> {
    document["axes"].as_array().unwrap()
}
