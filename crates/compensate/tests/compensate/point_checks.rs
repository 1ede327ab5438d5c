//! Deviations of the tool at single places against predictions.

use nalgebra::{Isometry3, Point3, Rotation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::{Campaign, PointCheck, PointCheckReading};
use trueaxis_compensate::{Moved, Verified, correct, verify};
use trueaxis_kinematics::{GeometricErrors, Ideal, MICROMETRE};
use trueaxis_predict::CalibratedMachine;
use trueaxis_simulate::{Scenario, TrueMachine, simulate};

use crate::{FIVE_AXES, THREE_AXES, calibrated, poses, scenario, tool};

const U_UM: f64 = 0.4;

/// Normal to the fourth moment: the sum of twelve uniform ones.
fn deviate(rng: &mut ChaCha8Rng) -> f64 {
    (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
}

/// The point of the tool as an observer on the table sees it, from where three marks on the table are, mm.
fn seen_from_the_table(
    truth: &TrueMachine,
    errors: &impl GeometricErrors,
    positions: &[f64],
    tool_home_mm: Point3<f64>,
) -> Point3<f64> {
    let machine = truth.machine();
    let on_tool = machine.position(errors, 2, positions, tool_home_mm);
    let Some(table) = (positions.len() > 3).then(|| positions.len() - 1) else {
        return on_tool;
    };
    let mark = |home: Point3<f64>| machine.position(errors, table, positions, home);
    let origin = mark(Point3::origin());
    let [x, y] = [Vector3::x(), Vector3::y()].map(|along| mark(Point3::from(along)) - origin);
    let turned = Rotation3::from_basis_unchecked(&[x, y, x.cross(&y)]);
    let table = Isometry3::from_parts(origin.into(), UnitQuaternion::from_rotation_matrix(&turned));
    table.inverse() * on_tool
}

/// What an instrument with a zero of its own reads of `truth` at some places with two tools, some coordinates left out.
fn measured(
    truth: &TrueMachine,
    places: &[Vec<f64>],
    compensated_by: Option<&CalibratedMachine>,
    seed: u64,
) -> PointCheck {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let tools = [tool(), tool() + Vector3::new(0.0, 10.0, -120.0)];
    let zeros = tools.map(|_| Vector3::from_fn(|_, _| 20.0 * deviate(&mut rng)));
    let readings = places.iter().enumerate().map(|(row, positions)| {
        let (tool_home_mm, zero) = (tools[row % 2], zeros[row % 2]);
        let sent = compensated_by.map_or_else(
            || positions.clone(),
            |calibrated| {
                let machine = calibrated.machine();
                let corrected = correct(machine, calibrated, positions, tool_home_mm, Moved::All);
                corrected.unwrap().positions
            },
        );
        let actual = seen_from_the_table(truth, truth, &sent, tool_home_mm);
        let wanted = seen_from_the_table(truth, &Ideal, positions, tool_home_mm);
        let deviation_um = (actual - wanted) / MICROMETRE + zero;
        let reading = deviation_um.map(|exact| exact + U_UM * deviate(&mut rng));
        PointCheckReading {
            time_s: None,
            cycle: None,
            positions: positions.clone(),
            tool_home_mm: Some(tool_home_mm),
            deviation_um: [0, 1, 2].map(|c| (row % 5 != c + 1).then_some(reading[c])),
            line: row + 2,
        }
    });
    PointCheck {
        name: "ball plate".to_owned(),
        u_um: Some(U_UM),
        u_ppm: None,
        readings: readings.collect(),
    }
}

fn verified(
    scenario: &Scenario,
    machine: &CalibratedMachine,
    check: PointCheck,
    compensated: bool,
) -> Verified {
    let campaign = Campaign {
        verification: Vec::new(),
        point_checks: vec![check],
        ..simulate(scenario, 1).unwrap().campaign
    };
    let mut verified = verify(machine, &campaign, compensated).unwrap();
    assert_eq!(verified.len(), 1);
    verified.remove(0)
}

/// Readings of the truth agree with the prediction of a calibration inside U, on three axes as on five, with compensation where it was
/// switched on; and the wrong switch is seen. The readings share the errors of the calibration, so that the share above 1 scatters
/// more than that of independent ones: 12 % of the 10 × 184 is some three standard deviations, and the seeds are fixed.
#[test]
fn the_tool_is_where_the_calibration_says() {
    for text in [THREE_AXES, FIVE_AXES] {
        let scenario = scenario(text);
        let truth = scenario.true_machine().unwrap();
        let machine = calibrated(&scenario, false);
        let places = poses(&machine, 80);
        let (mut above, mut all) = (0, 0);
        for seed in 0..5 {
            for compensated_by in [None, Some(&machine)] {
                let check = measured(&truth, &places, compensated_by, seed);
                let agrees = verified(&scenario, &machine, check.clone(), compensated_by.is_some());
                let (a, n) = agrees.above_one();
                // 48 of the 240 coordinates are left out.
                assert_eq!((agrees.points.len(), n), (192, 192));
                (above, all) = (above + a, all + n);
                let size = |of: fn(&trueaxis_compensate::Point) -> f64| {
                    let all = agrees.points.iter().map(of);
                    all.fold(0.0, |largest: f64, x| largest.max(x.abs()))
                };
                let [predicted, compensated] =
                    [size(|p| p.predicted_um), size(|p| p.compensated_um)];
                assert!(
                    predicted > 20.0 && compensated < 1e-3,
                    "{predicted} {compensated}"
                );
                let wrong = verified(&scenario, &machine, check, compensated_by.is_none());
                assert!(wrong.above_one().0 > n / 2);
            }
        }
        println!("{above} of {all} |E_n| above 1");
        assert!((above as f64) < 0.12 * all as f64);
    }
}

/// The uncertainty of a difference of two places is that of the prediction at one of them where the other is home, which is certain.
#[test]
fn the_uncertainty_is_that_of_the_prediction() {
    let scenario = scenario(FIVE_AXES);
    let truth = scenario.true_machine().unwrap();
    let machine = calibrated(&scenario, false);
    let place = vec![250.0, 130.0, 310.0, -0.4, 1.1];
    let mut check = measured(
        &truth,
        &[vec![0.0; 5], Vec::new(), place.clone()][..1],
        None,
        1,
    );
    let home = check.readings[0].clone();
    check.readings.push(PointCheckReading {
        positions: place.clone(),
        ..home.clone()
    });
    for reading in &mut check.readings {
        reading.deviation_um = [Some(1.0), Some(2.0), Some(3.0)];
    }
    let found = verified(&scenario, &machine, check, false);
    let [at_home, there] = [vec![0.0; 5], place].map(|at| machine.predict(&at, tool()));
    for point in &found.points {
        let c = point.checked.unwrap().coordinate;
        // A mean is taken out of two: half of the difference is left, either way.
        let difference =
            (there.error.translation_mm - at_home.error.translation_mm)[c] / MICROMETRE;
        assert!((point.predicted_um.abs() - difference.abs() / 2.0).abs() < 1e-9);
        if at_home.u()[c] < 1e-12 {
            let u_um = there.u()[c] / MICROMETRE;
            assert!((point.u_prediction_um - u_um / 2.0).abs() < 1e-6 * u_um);
        }
    }
    let alone = PointCheck {
        readings: vec![home],
        name: "alone".to_owned(),
        u_um: Some(U_UM),
        u_ppm: None,
    };
    // A reading alone is its own zero.
    assert_eq!(
        verified(&scenario, &machine, alone, false).above_one(),
        (0, 0)
    );
}
