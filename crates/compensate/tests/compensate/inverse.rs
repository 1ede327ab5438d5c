//! Corrected positions: forward and inverse are inverse.

use nalgebra::Vector3;
use trueaxis_compensate::{Error, Moved, axis_deviations, correct};
use trueaxis_kinematics::{ARCSEC, GeometricErrors, Ideal, LocationError, MICROMETRE, MotionError};

use crate::{FIVE_AXES, TABLE, THREE_AXES, calibrated, poses, scenario, tool};

/// 1e-6 µm, and what a rotation of that over a metre is.
const RESIDUAL_MM: f64 = 1e-6 * MICROMETRE;
const RESIDUAL_RAD: f64 = 1e-12;

/// At corrected positions the tool is where the command means it to be, to 1e-6 µm; and the positions that were commanded
/// come back from where the machine with errors goes.
#[test]
fn forward_and_inverse_are_inverse() {
    for text in [THREE_AXES, FIVE_AXES] {
        let calibrated = calibrated(&scenario(text), false);
        let machine = calibrated.machine();
        for commanded in poses(&calibrated, 200) {
            let there =
                |positions: &[f64]| machine.tool_in_workpiece(&calibrated, positions) * tool();
            let wanted = machine.tool_in_workpiece(&Ideal, &commanded) * tool();
            for moved in [Moved::Linear, Moved::All] {
                let found = correct(machine, &calibrated, &commanded, tool(), moved).unwrap();
                let off = there(&found.positions) - wanted;
                assert!(off.norm() < RESIDUAL_MM, "{commanded:?}: {:e}", off.norm());
                assert!((found.left.translation_mm - off).norm() < RESIDUAL_MM);
                assert!(found.contraction < 1e-2, "{found:?}");
            }
            // Back: command the linear axes to where the tool was found.
            let e = machine
                .tool_error(&calibrated, &commanded, tool())
                .translation_mm;
            let e = machine
                .chain_motion(
                    &Ideal,
                    machine.branch(trueaxis_kinematics::Branch::Workpiece),
                    &commanded,
                )
                .rotation
                * e;
            let mut reached = commanded.clone();
            (0..3).for_each(|axis| reached[axis] += e[axis]);
            let back = correct(machine, &calibrated, &reached, tool(), Moved::Linear).unwrap();
            for (a, b) in back.positions.iter().zip(&commanded) {
                assert!((a - b).abs() < RESIDUAL_MM, "{a} {b}");
            }
        }
    }
}

/// What stays: the whole rotation of the tool on a machine of three linear axes; with a rotary and a tilting axis the
/// rotation about the one direction that neither of them makes.
#[test]
fn what_no_axis_makes_stays() {
    let three = calibrated(&scenario(THREE_AXES), false);
    let five = calibrated(&scenario(FIVE_AXES), false);
    let mut largest = 0.0_f64;
    for commanded in poses(&three, 50) {
        let machine = three.machine();
        let error = machine.tool_error(&three, &commanded, tool());
        let left = correct(machine, &three, &commanded, tool(), Moved::All)
            .unwrap()
            .left;
        // To second order: the correction moves the axes by some 10 µm.
        let off = left.rotation_rad - error.rotation_rad;
        assert!(
            off.norm() < 1e-3 * ARCSEC + 0.01 * error.rotation_rad.norm(),
            "{off}"
        );
        largest = largest.max(left.rotation_rad.norm());
    }
    assert!(largest > ARCSEC, "{largest}");
    for commanded in poses(&five, 50) {
        let machine = five.machine();
        let left = correct(machine, &five, &commanded, tool(), Moved::All)
            .unwrap()
            .left;
        // Directions of A and C, seen from the workpiece: C stands still in it, A is turned back by C.
        let (c, a) = (
            Vector3::z(),
            nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), -commanded[4]) * Vector3::x(),
        );
        for direction in [c, a] {
            let along = direction.dot(&left.rotation_rad);
            assert!(along.abs() < RESIDUAL_RAD, "{commanded:?}: {along:e}");
        }
    }
}

/// A rotary table alone corrects its angle.
#[test]
fn a_table_corrects_its_angle() {
    let table = calibrated(&scenario(TABLE), false);
    let machine = table.machine();
    for commanded in poses(&table, 20) {
        let found = correct(machine, &table, &commanded, tool(), Moved::All).unwrap();
        assert!(found.left.rotation_rad.z.abs() < RESIDUAL_RAD);
        let linear = correct(machine, &table, &commanded, tool(), Moved::Linear).unwrap();
        assert_eq!(linear.positions, commanded);
        assert_eq!(linear.iterations, 0);
    }
}

/// The deviations of the axes are the first order of the corrections.
#[test]
fn deviations_are_the_first_order() {
    let five = calibrated(&scenario(FIVE_AXES), false);
    let machine = five.machine();
    for commanded in poses(&five, 50) {
        let found = correct(machine, &five, &commanded, tool(), Moved::All).unwrap();
        let deviations = axis_deviations(machine, &five, &commanded, tool(), Moved::All);
        for ((position, commanded), deviation) in
            found.positions.iter().zip(&commanded).zip(deviations)
        {
            let sum = position - commanded + deviation;
            assert!(sum.abs() < 0.05 * MICROMETRE, "{sum:e}");
        }
    }
}

/// A wave of 2 mm amplitude every 10 mm is no error of a machine.
#[test]
fn errors_without_an_inverse_are_refused() {
    struct Wave;
    impl GeometricErrors for Wave {
        fn location(&self, _: usize) -> LocationError {
            LocationError::default()
        }
        fn motion(&self, axis: usize, position: f64) -> MotionError {
            let wave = if axis == 0 {
                2.0 * (position / 1.6).sin()
            } else {
                0.0
            };
            MotionError::new(Vector3::x() * wave, Vector3::zeros())
        }
    }
    let machine = scenario(THREE_AXES).true_machine().unwrap();
    let refused = correct(
        machine.machine(),
        &Wave,
        &[103.0, 0.0, 0.0],
        tool(),
        Moved::All,
    );
    assert!(
        matches!(refused, Err(Error::NotContracting { .. })),
        "{refused:?}"
    );
}
