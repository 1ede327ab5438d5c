//! Campaigns that look damaged but hold all that is needed: they are calibrated.

use std::fs;

use serde_json::{Value, json};

use crate::campaign_files::CampaignFiles;
use crate::program::{Outcome, run};

/// A change and what the program must say nevertheless.
struct Harmless {
    name: &'static str,
    change: fn(&mut CampaignFiles),
    says: &'static [&'static str],
}

fn calibrate(files: &CampaignFiles) -> (Outcome, Option<Value>) {
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(
        folder.path(),
        &["calibrate", "campaign.json", "--out", "out"],
    );
    let text = fs::read(folder.path().join("out/calibration.json"));
    (
        outcome,
        text.ok().map(|text| serde_json::from_slice(&text).unwrap()),
    )
}

#[test]
fn calibrated_nevertheless() {
    let sound = CampaignFiles::shipped("fxyz");
    for harmless in [
        Harmless {
            name: "byte order mark and line ends of another system",
            change: |files| {
                files.text("lengths.csv", |text| {
                    format!("\u{feff}{}", text.replace('\n', "\r\n"))
                });
            },
            says: &[],
        },
        Harmless {
            name: "no newline at the end",
            change: |files| files.text("lengths.csv", |text| text.trim_end().to_owned()),
            says: &["notice: lengths.csv: the last line has no end"],
        },
        Harmless {
            name: "a column of the air's temperature",
            change: |files| files.table(|table| table.add_column("air_temp_c", "20.1")),
            says: &[],
        },
        Harmless {
            name: "point seen from three stations of four",
            change: |files| {
                files.keep(|row| {
                    let texts = [
                        ("station", "S1"),
                        ("run", "x"),
                        ("X", "200"),
                        ("target", "Q"),
                    ];
                    !row.is(&texts)
                });
            },
            says: &[],
        },
        Harmless {
            name: "a repeat of one station missing",
            change: |files| files.keep(|row| !row.is(&[("station", "S2"), ("repeat", "3")])),
            says: &[],
        },
        Harmless {
            name: "a run that nobody measured",
            change: |files| files.keep(|row| !row.is(&[("run", "z")])),
            says: &[
                "notice: lengths.csv: run `z` of campaign.json has no row",
                "notice: no run measures Z",
            ],
        },
        Harmless {
            name: "a clock that was reset",
            change: |files| files.cell(101, "time_s", "1"),
            says: &["notice: lengths.csv line 101, column time_s", "goes back"],
        },
        Harmless {
            name: "no declared noise",
            change: |files| {
                files.json(|json| drop(json.as_object_mut().unwrap().remove("instrument")));
            },
            says: &["notice: the noise is not declared"],
        },
        Harmless {
            name: "half of the accuracy declared, in nm",
            change: |files| {
                files.json(|json| {
                    json["instrument"] = json!({ "name": "tracker", "length_sigma_um": 269 });
                });
            },
            says: &[
                "notice: `repeatability_um` is not declared",
                "notice: `length_sigma_um` is declared as 269 µm, but the lengths show 0.2",
            ],
        },
        Harmless {
            name: "accuracy declared ten times too good",
            change: |files| {
                files.set("/instrument/length_sigma_um", json!(0.0269));
                files.set("/instrument/repeatability_um", json!(0.1));
            },
            says: &[
                "notice: the residuals are",
                "uncertainties follow the residuals",
            ],
        },
        Harmless {
            name: "lengths in another scale",
            change: |files| files.scale("length_mm", 1.001),
            says: &[
                "the measured triangle is not the nominal one",
                "P to Q",
                "P to K",
                "Q to K",
            ],
        },
    ] {
        let mut files = sound.clone();
        (harmless.change)(&mut files);
        let (outcome, calibration) = calibrate(&files);
        let name = harmless.name;
        assert_eq!(outcome.code, Some(0), "{name}: {}", outcome.stderr);
        assert!(calibration.is_some(), "{name}");
        for part in harmless.says {
            let stderr = &outcome.stderr;
            assert!(stderr.contains(part), "{name}: no `{part}` in: {stderr}");
        }
    }
}

/// The names of stations mean nothing by themselves: exchanged in every row, all else is the same.
#[test]
fn stations_exchanged_everywhere() {
    let mut files = CampaignFiles::shipped("rotary-stage");
    let (outcome, before) = calibrate(&files);
    outcome.assert_good();
    files.exchange("station", ["S1", "S2"], |_| true);
    let (outcome, after) = calibrate(&files);
    outcome.assert_good();
    let (before, after) = (before.unwrap(), after.unwrap());
    let component = "/axes/0/components/EXC/value_um";
    for (a, b) in numbers(&before, component)
        .iter()
        .zip(numbers(&after, component))
    {
        assert!((a - b).abs() < 1e-4, "{a} µm became {b} µm");
    }
    let (first, second) = ("/stations/0/position_mm", "/stations/1/position_mm");
    for (place, other) in [(first, second), (second, first)] {
        for (a, b) in numbers(&before, place).iter().zip(numbers(&after, other)) {
            assert!((a - b).abs() < 1e-4, "{a} mm became {b} mm");
        }
    }
}

fn numbers(document: &Value, pointer: &str) -> Vec<f64> {
    let list = document.pointer(pointer).unwrap().as_array().unwrap();
    list.iter().map(|number| number.as_f64().unwrap()).collect()
}
