//! The shipped scenarios and the one in the documentation.

use std::path::Path;

use trueaxis_kinematics::ARCSEC;
use trueaxis_simulate::{Scenario, Simulated, simulate};

use crate::shipped;

fn simulated(name: &str) -> Simulated {
    simulate(&Scenario::read(shipped::path(name)).unwrap(), 1).unwrap()
}

#[test]
fn fxyz_is_the_papers_three_axis_machine() {
    let Simulated { campaign, truth } = simulated("fxyz");
    // 4 stations, 3 repeats, 23 + 21 + 21 steps, 3 targets.
    assert_eq!(campaign.lengths.unwrap().readings.len(), 2340);
    let squareness: Vec<_> = truth
        .location_errors
        .iter()
        .map(|location| {
            (
                location.name.as_str(),
                (location.value / ARCSEC * 1e3).round() / 1e3,
            )
        })
        .collect();
    assert_eq!(
        squareness,
        [("C0Y", -22.925), ("A0Z", 19.614), ("B0Z", -27.377)]
    );
}

#[test]
fn rotary_stage_has_the_papers_targets_and_no_axial_location() {
    let Simulated { campaign, truth } = simulated("rotary-stage");
    // 4 stations, 3 repeats, 19 steps, 3 targets.
    assert_eq!(campaign.lengths.unwrap().readings.len(), 684);
    let names: Vec<_> = truth
        .location_errors
        .iter()
        .map(|l| l.name.as_str())
        .collect();
    assert_eq!(names, ["X0C", "Y0C", "A0C", "B0C"]);
    assert!(
        truth
            .location_errors
            .iter()
            .all(|location| location.value != 0.0)
    );
}

#[test]
fn five_axis_measures_every_axis_in_both_directions() {
    let Simulated { campaign, truth } = simulated("five-axis");
    // 4 stations, 2 repeats, 2 directions, 3 · 11 + 11 + 13 steps, 3 targets; a row has 75 bytes.
    assert_eq!(campaign.lengths.unwrap().readings.len(), 2736);
    let names: Vec<_> = truth
        .location_errors
        .iter()
        .map(|l| l.name.as_str())
        .collect();
    let expected = "C0Y A0Z B0Z X0A Y0A Z0A B0A C0A X0C Y0C Z0C A0C B0C";
    assert_eq!(names.join(" "), expected);
    assert!(
        truth
            .location_errors
            .iter()
            .all(|location| location.value != 0.0)
    );
}

/// Errors of a machine one would meet: at most 20 µm and 15 arcsec, and none forgotten.
#[test]
fn errors_are_realistic() {
    for name in shipped::NAMES {
        for axis in simulated(name).truth.axes {
            for (i, limit) in [
                20e-3,
                20e-3,
                20e-3,
                15.0 * ARCSEC,
                15.0 * ARCSEC,
                15.0 * ARCSEC,
            ]
            .into_iter()
            .enumerate()
            {
                let largest = axis
                    .errors
                    .iter()
                    .map(|e| e.to_vector()[i].abs())
                    .fold(0.0, f64::max);
                assert!(
                    largest < limit && largest > limit / 20.0,
                    "{name} {} {i}: {largest}",
                    axis.name
                );
            }
        }
    }
}

#[test]
fn the_documented_example_can_be_simulated() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scenario.md");
    let text = std::fs::read_to_string(docs).unwrap();
    let example = text
        .split("```json")
        .nth(1)
        .unwrap()
        .split("```")
        .next()
        .unwrap();
    let simulated = simulate(&Scenario::from_json(example).unwrap(), 1).unwrap();
    // 2 stations, 2 repeats: 9 steps up and down with two targets, 4 steps with one.
    assert_eq!(
        simulated.campaign.lengths.unwrap().readings.len(),
        4 * (9 * 2 * 2 + 4)
    );
}
