//! Two calibrations of one machine.

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_kinematics::{AxisKind, MICROMETRE};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::{Scenario, Term, simulate};

fn scenario() -> Scenario {
    Scenario::from_json(include_str!("../../../../campaigns/fxyz/scenario.json")).unwrap()
}

fn calibrated(scenario: &Scenario, seed: u64) -> CalibratedMachine {
    let campaign = simulate(scenario, seed).unwrap().campaign;
    let calibration = calibrate(&campaign, &Settings::default()).unwrap();
    calibration.calibrated_machine()
}

/// The same machine twice, with other noise: `|E_n|` exceeds 1 in about 4.6 % of the differences. Those of a calibration go
/// together (18 curves); 15 % has a probability of some 1 %, and the seeds are fixed. A change by 12 µm over X
/// (a slope of 6 µm for each half) is found, and nothing else.
#[test]
fn noise_is_no_difference_and_a_repair_is_one() {
    let before = calibrated(&scenario(), 1);
    let again = calibrated(&scenario(), 2);
    let differences = before.compare(&again).unwrap();
    // 18 curves of 23, 21, 21 steps, and three squarenesses.
    assert_eq!(differences.len(), 6 * (23 + 21 + 21) + 3);
    let e_n: Vec<f64> = differences.iter().filter_map(|d| d.e_n()).collect();
    let above = e_n.iter().filter(|e_n| e_n.abs() > 1.0).count();
    println!("{above} of {} |E_n| above 1", e_n.len());
    assert!(e_n.len() > 300 && (above as f64) < 0.15 * e_n.len() as f64);
    // What is zero by definition, at home.
    let home = |d: &&trueaxis_predict::Difference| d.name == "EXX" && d.position == Some(0.0);
    let at_home = differences.iter().find(home).unwrap();
    assert!(at_home.value().abs() < 1e-9, "{at_home:?}");

    // Of its own only noise: the opposite way round it is the opposite.
    let back = again.compare(&before).unwrap();
    for (there, back) in differences.iter().zip(&back) {
        assert!((there.value() + back.value()).abs() < 1e-15 && (there.u - back.u).abs() < 1e-15);
    }

    let mut repaired = scenario();
    let curve = repaired
        .errors
        .get_mut("X")
        .unwrap()
        .components
        .get_mut("EXX")
        .unwrap();
    curve.push(Term::Polynomial {
        coefficients: vec![0.0, 6.0],
    });
    let after = calibrated(&repaired, 3);
    let differences = before.compare(&after).unwrap();
    let exx: Vec<_> = differences.iter().filter(|d| d.name == "EXX").collect();
    let last = exx[exx.len() - 1];
    assert!(
        (last.value() / MICROMETRE - 12.0).abs() < 4.0 * last.u / MICROMETRE,
        "{last:?}"
    );
    let changed = differences.iter().filter(|d| d.is_beyond_noise());
    let changed: Vec<&str> = changed.map(|d| d.name.as_str()).collect();
    assert!(
        changed.len() > 5 && changed.iter().all(|name| *name == "EXX"),
        "{changed:?}"
    );
}

/// A second measurement over half of the travel of X has other average lines, which is said; the same travel is not.
#[test]
fn other_travels_are_told() {
    let whole = calibrated(&scenario(), 1);
    assert!(whole.other_travels(&calibrated(&scenario(), 2)).is_empty());
    let json = include_str!("../../../../campaigns/fxyz/scenario.json");
    let half = json.replace("\"stop\": 440", "\"stop\": 220");
    assert_ne!(half, json);
    let half = calibrated(&Scenario::from_json(&half).unwrap(), 2);
    let travels = [[0.0, 440.0], [0.0, 220.0]];
    assert_eq!(
        whole.other_travels(&half),
        [("X", AxisKind::Linear, travels)]
    );
}

/// X measured from 60 mm on has its zero there: every difference of its positioning is what the first calibration has at
/// 60 mm, which is said with both places. Where home is between two steps of both, nothing is to be said.
#[test]
fn a_home_that_was_not_measured_is_told() {
    let whole = calibrated(&scenario(), 1);
    assert!(whole.other_homes(&calibrated(&scenario(), 2)).is_empty());
    let json = include_str!("../../../../campaigns/fxyz/scenario.json");
    let with_x = |of: &str, to: &str| {
        let changed = json.replace(of, to);
        assert_ne!(changed, json);
        calibrated(&Scenario::from_json(&changed).unwrap(), 2)
    };
    let sweep = "\"start\": 0, \"stop\": 440";
    let away = with_x(sweep, "\"start\": 60, \"stop\": 440");
    let homes = [vec![0.0], vec![60.0]];
    let told = whole.other_homes(&away);
    assert_eq!(told, [("X", AxisKind::Linear, homes)]);
    let differences = whole.compare(&away).unwrap();
    let of_exx = || differences.iter().filter(|d| d.name == "EXX");
    let zero = of_exx().find(|d| d.position == Some(60.0)).unwrap().first;
    assert!(zero.abs() > 2.0 * MICROMETRE);
    assert!(of_exx().all(|d| (d.value() + zero).abs() < 5.0 * d.u));
    // Both from there on: none sees what is before.
    let homes = [vec![60.0], vec![60.0]];
    let told = away.other_homes(&away);
    assert_eq!(told, [("X", AxisKind::Linear, homes)]);

    let travel = "\"travel\": [0, 440]";
    let around = json.replace(travel, "\"travel\": [-10, 440]");
    let around = around.replace(sweep, "\"start\": -10, \"stop\": 430");
    let around = calibrated(&Scenario::from_json(&around).unwrap(), 2);
    let homes = [vec![0.0], vec![-10.0, 10.0]];
    let told = whole.other_homes(&around);
    assert_eq!(told, [("X", AxisKind::Linear, homes)]);
    assert!(around.other_homes(&around).is_empty());
}

/// With Y at 200 mm in the run of X its curves hold what Y does to it there: the place is told, of that pair alone.
#[test]
fn an_axis_that_was_parked_elsewhere_is_told() {
    let json = include_str!("../../../../campaigns/fxyz/scenario.json");
    let run = "\"axis\": \"X\", \"sweep\"";
    let parked = json.replace(
        run,
        "\"axis\": \"X\", \"parked\": { \"Y\": 200 }, \"sweep\"",
    );
    assert_ne!(parked, json);
    let [home, parked] =
        [json, &parked].map(|text| calibrated(&Scenario::from_json(text).unwrap(), 2));
    let told = home.other_parking(&parked);
    let [(axes, at)] = told[..] else {
        panic!("{told:?}")
    };
    assert_eq!(axes, [0, 1]);
    assert!(at[0].abs() < 1e-9 && (at[1] - 200.0).abs() < 1e-9, "{at:?}");
    assert!(parked.other_parking(&parked).is_empty());
}
