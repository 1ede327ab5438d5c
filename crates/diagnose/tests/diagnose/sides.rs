//! Lines against a calibration that has curves of its own for each side of approach.

use nalgebra::{Matrix6, Vector6};
use trueaxis_campaign::Direction;
use trueaxis_diagnose::{Diagnosis, Settings, Verdict, diagnose_against};
use trueaxis_kinematics::{LocationError, MICROMETRE, MotionError};
use trueaxis_predict::{CalibratedMachine, FactoredCovariance, MeasuredAxis, Node};

use crate::iso_run::{places, table};
use crate::machines::normal;
use crate::{campaign, generator, three_axes};

const CALIBRATED_UM: f64 = 5.0;
const SIGMA_UM: f64 = 0.3;
/// Of each translation at each node.
const NODE_SIGMA_UM: f64 = 0.2;

/// X falls behind by half of its lost motion on either side, in steps of 20 mm.
fn calibration() -> CalibratedMachine {
    let (mut nodes, mut errors) = (Vec::new(), Vec::new());
    for step in 0..=20 {
        for direction in [Direction::Backward, Direction::Forward] {
            let behind_mm = -0.5 * CALIBRATED_UM * MICROMETRE * f64::from(direction.sign());
            nodes.push(Node {
                position: 20.0 * f64::from(step),
                direction: Some(direction),
            });
            errors.push(MotionError::from_vector(&Vector6::x().scale(behind_mm)));
        }
    }
    let variance = (NODE_SIGMA_UM * MICROMETRE).powi(2);
    let of_translations = Vector6::new(variance, variance, variance, 0.0, 0.0, 0.0);
    let factors = FactoredCovariance {
        own: vec![Matrix6::from_diagonal(&of_translations); nodes.len()],
        ..FactoredCovariance::zero(nodes.len(), 6 * nodes.len())
    };
    let axis = MeasuredAxis {
        axis: 0,
        nodes,
        errors,
        location: LocationError::default(),
        reported: Vec::new(),
    };
    CalibratedMachine::new(three_axes(), vec![axis], factors)
}

/// Readings of a machine with so much lost motion.
fn found(lost_um: f64, seed: u64) -> Diagnosis {
    let mut generator = generator(seed, 43);
    let places = places(5, &[0.0], &[2.0]);
    let values = places.iter().map(|place| {
        let side = place.side();
        -0.5 * lost_um * side + SIGMA_UM * normal(&mut generator)
    });
    let values: Vec<f64> = values.collect();
    let line = table(&places, &values, false);
    diagnose_against(&campaign(vec![line]), &calibration(), &Settings::default()).unwrap()
}

/// Six of the first 200 seeds raise an alarm; three or more of 20 have a probability of 2 %.
#[test]
fn the_calibrated_lost_motion_contradicts_nothing() {
    let is_clean = |seed: &u64| found(CALIBRATED_UM, *seed).verdict == Verdict::Clean;
    assert!((0..20).filter(is_clean).count() >= 18);
}

/// Within four standard uncertainties, which normal errors exceed with 6e-5.
#[test]
fn what_is_lost_beyond_the_calibration_is_named() {
    let found = found(CALIBRATED_UM + 3.0, 2);
    assert_eq!(found.verdict, Verdict::Named);
    let cause = &found.causes[0];
    assert_eq!(cause.effect.effect.id, "backlash");
    let size = &cause.parameters[0];
    assert!(
        (size.value.abs() - 3.0).abs() < 4.0 * size.u && size.u < 0.3,
        "{} ± {}",
        size.value,
        size.u
    );
}
