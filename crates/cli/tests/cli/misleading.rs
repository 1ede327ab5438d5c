//! Campaigns that mislead: what an adjustment alone would take for something else, or for good.

use std::fs;

use serde_json::{Value, json};

use crate::campaign_files::CampaignFiles;
use crate::program::run;
use crate::refused::{INPUT, NO_ANSWER, NOT_IDENTIFIABLE, assert_calibration_refused};

#[test]
fn other_axes_moving_in_a_run() {
    assert_calibration_refused(
        "fxyz",
        &[(
            "all rows under the name of one run",
            |files| files.column("run", |_| "x".to_owned()),
            INPUT,
            "run x … Y",
        )],
    );
}

#[test]
fn poor_positions_of_a_single_axis() {
    assert_calibration_refused(
        "fxyz",
        &[(
            "three positions close together",
            |files| {
                let positions = ["320", "340", "360"];
                files.keep(|row| row.text("run") == "x" && positions.contains(&row.text("X")));
            },
            NOT_IDENTIFIABLE,
            "stations",
        )],
    );
}

#[test]
fn contradictions_taken_for_missing_rank() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "stations exchanged at one step",
                |files| {
                    files.exchange("station", ["S1", "S2"], |row| {
                        row.is(&[("run", "x"), ("X", "200")])
                    });
                },
                NO_ANSWER,
                "check",
            ),
            (
                "all lengths of one station with the wrong sign",
                |files| {
                    files.column("length_mm", |row| {
                        let is_wrong = row.is(&[("station", "S2")]);
                        let sign = if is_wrong { -1.0 } else { 1.0 };
                        (sign * row.number("length_mm")).to_string()
                    });
                },
                NO_ANSWER,
                "station S2",
            ),
        ],
    );
}

#[test]
fn stations_on_a_line() {
    assert_calibration_refused(
        "rotary-stage",
        &[(
            "stations on a line",
            |files| {
                *files = CampaignFiles::simulated("rotary-stage", |scenario| {
                    let stations = scenario["stations"].as_array_mut().unwrap();
                    for (station, x_mm) in stations.iter_mut().zip([-1000, -300, 400, 1100]) {
                        station["position_mm"] = json!([x_mm, -900, 300]);
                    }
                });
            },
            NOT_IDENTIFIABLE,
            "stations",
        )],
    );
}

/// Rough positions decide nothing here, so the result is good; that they are wrong is said.
#[test]
fn rough_positions_of_some_stations_exchanged() {
    let mut files = CampaignFiles::shipped("rotary-stage");
    files.json(|json| {
        json["stations"][0]["approx_mm"] = json!([-420, -690, 260]);
        json["stations"][1]["approx_mm"] = json!([760, -310, 180]);
    });
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(folder.path(), &["calibrate", "campaign.json", "--out", "."]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for station in ["S1", "S2"] {
        let said = format!("notice: station {station} was found 1242 mm from its approx_mm");
        assert!(outcome.stderr.contains(&said), "{}", outcome.stderr);
    }
}

/// Stations at nearly one height over a table whose targets turn in a plane: the lengths leave
/// their heights so uncertain (7 mm) that no linear propagation holds.
#[test]
fn stations_nearly_in_a_plane() {
    let files = CampaignFiles::simulated("rotary-stage", |scenario| {
        let stations = scenario["stations"].as_array_mut().unwrap();
        for (station, height_mm) in stations.iter_mut().zip([250, 252, 250, 252]) {
            station["position_mm"][2] = json!(height_mm);
        }
    });
    let folder = tempfile::tempdir().unwrap();
    files.write(folder.path());
    let outcome = run(folder.path(), &["calibrate", "campaign.json", "--out", "."]);
    if outcome.code == Some(0) {
        let text = fs::read(folder.path().join("calibration.json")).unwrap();
        let calibration: Value = serde_json::from_slice(&text).unwrap();
        let tilt = &calibration["location_errors"]["B0C"];
        let value_arcsec = tilt["value_arcsec"].as_f64().unwrap();
        let u_arcsec = tilt["u_arcsec"].as_f64().unwrap();
        let true_arcsec = -17.341;
        assert!(
            (value_arcsec - true_arcsec).abs() < 5.0 * u_arcsec,
            "B0C = {value_arcsec}″ ± {u_arcsec}″, truth {true_arcsec}″"
        );
    } else {
        outcome.assert_failed("stations nearly in a plane", NOT_IDENTIFIABLE, "station");
    }
}

/// Errors that no machine tool has are a mistake in the files more often than not.
#[test]
fn absurd_errors_without_a_notice() {
    type Damage = (&'static str, &'static str, fn(&mut CampaignFiles));
    let damages: [Damage; 4] = [
        ("step mistyped by 10 mm", "fxyz", |files| {
            files.column("X", |row| row.text("X").replace("200", "210"));
        }),
        ("step mistyped by 1 degree", "rotary-stage", |files| {
            files.column("C", |row| row.text("C").replace("200", "201"));
        }),
        ("positions at nine tenths", "fxyz", |files| {
            files.scale("X", 0.9);
        }),
        ("axis 5 degrees off", "fxyz", |files| {
            files.set("/machine/axes/0/direction", json!([0.99619, 0.08716, 0]));
        }),
    ];
    for (name, campaign, damage) in damages {
        let mut files = CampaignFiles::shipped(campaign);
        damage(&mut files);
        let folder = tempfile::tempdir().unwrap();
        files.write(folder.path());
        let outcome = run(folder.path(), &["calibrate", "campaign.json", "--out", "."]);
        let is_refused = outcome.code == Some(INPUT) || outcome.code == Some(NO_ANSWER);
        assert!(
            is_refused || outcome.stderr.contains("notice: axis"),
            "{name}: {}",
            outcome.stderr
        );
    }
}
