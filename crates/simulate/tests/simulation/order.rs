//! Order, stops, steps and clock of a campaign.

use nalgebra::Point3;
use serde_json::json;
use trueaxis_campaign::{Campaign, Direction, Lengths};
use trueaxis_simulate::simulate;

use crate::shipped;

fn two_way() -> (Campaign, Lengths) {
    let json = json!({
        "format": "trueaxis-scenario", "version": 1, "name": "two way",
        "machine": {
            "name": "stage", "kinematics": { "tool": ["X", "Y"] },
            "axes": [
                { "name": "X", "kind": "linear", "direction": [1, 0, 0], "travel": [0, 100] },
                { "name": "Y", "kind": "linear", "direction": [0, 1, 0], "travel": [-50, 50] }
            ]
        },
        "targets": [
            { "name": "P", "position_mm": [0, 0, 0], "carried_by": "Y" },
            { "name": "Q", "position_mm": [0, 0, 90], "carried_by": "X" }
        ],
        "stations": [
            { "name": "A", "position_mm": [949, -1051, 120], "dead_path_mm": 0, "declare_approx": true },
            { "name": "B", "position_mm": [-900, 500, 300], "dead_path_mm": 0 }
        ],
        "runs": [
            { "name": "y", "axis": "Y", "positions": [-50, 20], "directions": [-1, 1], "parked": { "X": 60 } },
            { "name": "x", "axis": "X", "positions": [0, 70, 100], "targets": ["Q", "P"] }
        ],
        "repeats": 2,
        "timing": { "start_s": 10, "per_reading_s": 1.5, "per_move_s": 3.0004, "per_station_change_s": 600 }
    });
    let mut campaign = simulate(&shipped::scenario(&json), 1).unwrap().campaign;
    let lengths = campaign.lengths.take().unwrap();
    (campaign, lengths)
}

#[test]
fn stations_then_repeats_then_runs_then_directions_then_positions() {
    let (campaign, lengths) = two_way();
    let visits: Vec<_> = lengths
        .stops
        .iter()
        .map(|stop| {
            let step = &campaign.steps[stop.step];
            let sign = match stop.direction {
                Direction::Forward => '+',
                Direction::Backward => '-',
            };
            let run = &campaign.runs[step.run.unwrap()].name;
            let targets = &lengths.readings[stop.readings.clone()];
            let targets: Vec<_> = targets
                .iter()
                .map(|r| campaign.targets[r.target].name.as_str())
                .collect();
            let station = &campaign.stations[stop.station].name;
            format!(
                "{station}{} {run}{sign} {:?} {}",
                stop.repeat,
                step.positions,
                targets.concat()
            )
        })
        .collect();
    let sweep = [
        "y- [60.0, 20.0] P",
        "y- [60.0, -50.0] P",
        "y+ [60.0, -50.0] P",
        "y+ [60.0, 20.0] P",
        "x+ [0.0, 0.0] QP",
        "x+ [70.0, 0.0] QP",
        "x+ [100.0, 0.0] QP",
    ];
    let expected: Vec<_> = ["A1", "A2", "B1", "B2"]
        .iter()
        .flat_map(|occupation| sweep.map(|visit| format!("{occupation} {visit}")))
        .collect();
    assert_eq!(visits, expected);
}

#[test]
fn steps_are_numbered_as_first_visited_and_shared() {
    let (campaign, lengths) = two_way();
    assert_eq!(campaign.steps.len(), 5);
    let first_turn: Vec<_> = lengths.stops[..7].iter().map(|stop| stop.step).collect();
    assert_eq!(first_turn, [0, 1, 1, 0, 2, 3, 4]);
}

#[test]
fn readings_are_covered_by_stops_and_numbered_like_the_file() {
    let (_, lengths) = two_way();
    let mut next = 0;
    for stop in &lengths.stops {
        assert_eq!(stop.readings.start, next);
        next = stop.readings.end;
    }
    assert_eq!(next, lengths.readings.len());
    let lines = lengths.readings.iter().map(|reading| reading.line);
    assert!(lines.eq(2..lengths.readings.len() + 2));
}

#[test]
fn the_clock_counts_moves_readings_and_station_changes_in_milliseconds() {
    let (_, lengths) = two_way();
    let times: Vec<f64> = lengths
        .readings
        .iter()
        .map(|reading| reading.time_s)
        .collect();
    // Start 10, move 3.0004; one reading of 1.5, move; after four stops of y, stops of two.
    assert_eq!(times[..6], [13.0, 17.501, 22.001, 26.502, 31.002, 32.502]);
    // 14 stops and 20 readings per station, then the change.
    let station_b = 10.0 + 14.0 * 3.0004 + 20.0 * 1.5 + 600.0 + 3.0004;
    assert!((times[20] - station_b).abs() <= 0.5e-3);
}

#[test]
fn a_station_is_declared_to_100_mm_if_at_all() {
    let (campaign, _) = two_way();
    let paced = Point3::new(900.0, -1100.0, 100.0);
    assert_eq!(campaign.stations[0].approx_mm, Some(paced));
    assert_eq!(campaign.stations[1].approx_mm, None);
}
