//! Campaigns that are true but determine too little: what is missing is named.

use serde_json::{Value, json};

use crate::campaign_files::CampaignFiles;
use crate::refused::{NOT_IDENTIFIABLE, assert_calibration_refused, assert_refused_by_nine};

#[test]
fn too_few_stations() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "two stations",
                |files| keep_stations(files, 2),
                NOT_IDENTIFIABLE,
                "at least 4 stations, found 2 … more stations",
            ),
            (
                "three stations",
                |files| keep_stations(files, 3),
                NOT_IDENTIFIABLE,
                "at least 4 stations, found 3 … more stations",
            ),
            (
                "three stations with rows",
                |files| files.keep(|row| !row.is(&[("station", "S4")])),
                NOT_IDENTIFIABLE,
                "at least 4 stations, found 3 … more stations",
            ),
            (
                "step seen from one station",
                |files| {
                    files.keep(|row| {
                        let is_point = row.is(&[("run", "x"), ("X", "200")]);
                        let is_seen = row.text("station") == "S3";
                        is_seen || !is_point
                    });
                },
                NOT_IDENTIFIABLE,
                "run x at X = 200 mm … do not determine the pose … measure it from the \
                 missing stations",
            ),
            (
                "position mistyped in one row",
                |files| files.cell(101, "Y", "201"),
                NOT_IDENTIFIABLE,
                "target P in run y at X = 0 mm, Y = 201 mm … from 1 station",
            ),
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[(
            "two stations under one name",
            |files| {
                files.column("station", |row| match row.text("station") {
                    "S1" => "S2".to_owned(),
                    other => other.to_owned(),
                });
            },
            NOT_IDENTIFIABLE,
            "at least 4 stations, found 3",
        )],
    );
}

#[test]
fn too_few_targets_and_steps() {
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "target missing at a step",
                |files| {
                    files.keep(|row| !row.is(&[("run", "x"), ("X", "200"), ("target", "Q")]));
                },
                NOT_IDENTIFIABLE,
                "run x at X = 200 mm … 2 of the targets … three are needed",
            ),
            (
                "target missing everywhere",
                |files| files.keep(|row| !row.is(&[("target", "K")])),
                NOT_IDENTIFIABLE,
                "2 of the targets … three are needed",
            ),
            (
                "one step in a run",
                |files| files.keep(|row| row.text("run") != "x" || row.is(&[("X", "200")])),
                NOT_IDENTIFIABLE,
                "axis X … 1 position, … measure it at more positions",
            ),
            (
                "one step in a run, at home",
                |files| files.keep(|row| row.text("run") != "x" || row.is(&[("X", "0")])),
                NOT_IDENTIFIABLE,
                "axis X … 1 position, … measure it at more positions",
            ),
            (
                "one linear axis at one position",
                |files| files.keep(|row| row.is(&[("run", "x"), ("X", "200")])),
                NOT_IDENTIFIABLE,
                "of the stations free … dead path of S1",
            ),
            (
                "one linear axis at two positions",
                |files| {
                    files.keep(|row| {
                        row.is(&[("run", "x")]) && ["0", "440"].contains(&row.text("X"))
                    });
                },
                NOT_IDENTIFIABLE,
                "of the stations free … dead path of S1",
            ),
        ],
    );
    assert_calibration_refused(
        "rotary-stage",
        &[
            (
                "target missing at an angle",
                |files| files.keep(|row| !row.is(&[("C", "200"), ("target", "Q")])),
                NOT_IDENTIFIABLE,
                "run c at C = 200° … 2 of the targets … three are needed",
            ),
            (
                "one angle",
                |files| files.keep(|row| row.is(&[("C", "0")])),
                NOT_IDENTIFIABLE,
                "of the stations free",
            ),
            (
                "two angles",
                |files| files.keep(|row| ["0", "180"].contains(&row.text("C"))),
                NOT_IDENTIFIABLE,
                "of the stations free",
            ),
        ],
    );
}

/// With noise, as measured.
#[test]
fn bad_places() {
    assert_calibration_refused(
        "rotary-stage",
        &[
            (
                "targets on a line",
                |files| {
                    *files = CampaignFiles::simulated("rotary-stage", |scenario| {
                        let place = [-11.9422, 116.3312, 15.9919];
                        scenario["targets"][2]["position_mm"] = json!(place);
                        without_mounting_errors(scenario);
                    });
                },
                NOT_IDENTIFIABLE,
                "targets P, Q, K … on one line … place one target well away",
            ),
            (
                "stations at one place, the same lengths",
                same_lengths_from_every_station,
                NOT_IDENTIFIABLE,
                "run c at C = 0° … do not determine the pose … spread the stations",
            ),
            (
                "stations at one place",
                |files| {
                    *files = CampaignFiles::simulated("rotary-stage", |scenario| {
                        for station in 1..4 {
                            move_station(scenario, station, [760.0, -310.0, 180.0]);
                        }
                    });
                },
                NOT_IDENTIFIABLE,
                "station",
            ),
        ],
    );
    assert_calibration_refused(
        "fxyz",
        &[
            (
                "targets on a line",
                |files| {
                    *files = CampaignFiles::simulated("fxyz", |scenario| {
                        let place = [86.712, 392.6545, 223.6475];
                        scenario["targets"][2]["position_mm"] = json!(place);
                        without_mounting_errors(scenario);
                    });
                },
                NOT_IDENTIFIABLE,
                "targets P, Q, K … on one line … place one target well away",
            ),
            (
                "stations at one place, the same lengths",
                same_lengths_from_every_station,
                NOT_IDENTIFIABLE,
                "run x at X = 0 mm … do not determine the pose … spread the stations",
            ),
        ],
    );
}

fn keep_stations(files: &mut CampaignFiles, count: usize) {
    let names = &["S1", "S2", "S3", "S4"][..count];
    files.json(|json| json["stations"].as_array_mut().unwrap().truncate(count));
    files.keep(|row| names.contains(&row.text("station")));
}

fn move_station(scenario: &mut Value, station: usize, position_mm: [f64; 3]) {
    scenario["stations"][station]["position_mm"] = json!(position_mm);
}

fn without_mounting_errors(scenario: &mut Value) {
    for target in scenario["targets"].as_array_mut().unwrap() {
        target.as_object_mut().unwrap().remove("mounting_error_mm");
    }
}

/// All stations measure in the same order, so that the rows of each are those of the first, but for
/// the dead path: the very same lengths would be refused as a copy.
fn same_lengths_from_every_station(files: &mut CampaignFiles) {
    files.table(|table| {
        let first = table.rows.len() / 4;
        for i in first..table.rows.len() {
            let length: f64 = table.rows[i % first].last().unwrap().parse().unwrap();
            let nearer_mm = (i / first) as f64;
            *table.rows[i].last_mut().unwrap() = (length - nearer_mm).to_string();
        }
    });
}

/// Rigid stages determine these; free points do not.
#[test]
fn too_little_for_free_points() {
    assert_refused_by_nine(
        "rotary-stage",
        &[
            (
                "two stations at one place",
                |files| {
                    *files = CampaignFiles::simulated("rotary-stage", |scenario| {
                        move_station(scenario, 1, [760.0, -310.0, 180.0]);
                    });
                },
                NOT_IDENTIFIABLE,
                "dead path of S1 … dead path of S2 … spread the stations",
            ),
            (
                "stations in a plane",
                |files| {
                    *files = CampaignFiles::simulated("rotary-stage", |scenario| {
                        for station in scenario["stations"].as_array_mut().unwrap() {
                            station["position_mm"][2] = json!(250);
                        }
                    });
                },
                NOT_IDENTIFIABLE,
                "of the stations free … spread the stations",
            ),
            (
                "point seen from two stations",
                |files| {
                    files.keep(|row| {
                        let is_point = row.is(&[("C", "200"), ("target", "Q")]);
                        let is_seen = ["S3", "S4"].contains(&row.text("station"));
                        is_seen || !is_point
                    });
                },
                NOT_IDENTIFIABLE,
                "target Q in run c at C = 200° … from 2 stations, at least 3 … measure \
                 it from the missing stations",
            ),
        ],
    );
}
