//! Signs and units of disturbances, against shifts of the whole machine in known directions.

use nalgebra::Vector3;

use crate::blind::experiment::Experiment;
use crate::blind::{Act, Course, Hidden, Kind};

fn hidden(act: Act, axis: Option<usize>) -> Hidden {
    Hidden {
        name: "",
        act,
        course: Course::Constant,
        station: None,
        target: None,
        axis,
    }
}

/// Geometric errors of 1e-4 rad turn a disturbance of some µm by less than this, mm.
const TURNED_MM: f64 = 1e-6;

/// Readings of the X run, in the direction given, change as if the machine were shifted along X.
fn assert_shifts_x(act: Act, direction: f64, shift_um: f64) {
    let kind = Kind::three_axis().on_the_fly();
    let experiment = Experiment::new(&kind, 8);
    let shift = Act::Machine(Vector3::x() * shift_um);
    let found = experiment.exact_mm(&[hidden(act, Some(0))]);
    let expected = experiment.exact_mm(&[hidden(shift, None)]);
    let quiet = experiment.exact_mm(&[]);
    let visits = experiment.schedule.visits.iter().enumerate();
    for (row, visit) in visits {
        let runs = experiment.schedule.steps[visit.step].run == Some(0);
        if runs && (visit.direction - direction).abs() < 0.5 {
            let difference = found[row] - expected[row];
            assert!(difference.abs() < TURNED_MM, "row {row}: {difference:e}");
        } else if !runs {
            let difference = found[row] - quiet[row];
            assert!(difference.abs() < TURNED_MM, "row {row}: {difference:e}");
        }
    }
}

#[test]
fn lost_motion_leaves_the_axis_short() {
    assert_shifts_x(Act::LostMotion(4.0), 1.0, -2.0);
    assert_shifts_x(Act::LostMotion(4.0), -1.0, 2.0);
}

/// 20 mm in 2 s are 10 µm in a millisecond.
#[test]
fn late_readings_find_the_axis_further_on() {
    assert_shifts_x(Act::Late(0.2), 1.0, 2.0);
    assert_shifts_x(Act::Late(0.2), -1.0, -2.0);
}

#[test]
fn a_tripod_moves_against_the_machine() {
    let experiment = Experiment::new(&Kind::five_axis(), 8);
    let shift = Vector3::new(1.0, -2.0, 3.0);
    let tripod = experiment.exact_mm(&[hidden(Act::Tripod(shift), None)]);
    let machine = experiment.exact_mm(&[hidden(Act::Machine(-shift), None)]);
    for (a, b) in tripod.iter().zip(&machine) {
        assert!((a - b).abs() < 1e-11, "{:e}", a - b);
    }
}

#[test]
fn a_target_moves_with_its_stage() {
    let experiment = Experiment::new(&Kind::rotary_stage(), 8);
    // Along the axis of rotation the stage frame is the reference frame but for the errors.
    let along = Vector3::z() * 3.0;
    let target = experiment.exact_mm(&[hidden(Act::Target(along), None)]);
    let machine = experiment.exact_mm(&[hidden(Act::Machine(along), None)]);
    // Across it is turned: after half a turn it points back.
    let across = Vector3::x() * 3.0;
    let turned = experiment.exact_mm(&[hidden(Act::Target(across), None)]);
    let back = experiment.exact_mm(&[hidden(Act::Machine(-across), None)]);
    let mut row = 0;
    for visit in &experiment.schedule.visits {
        let angle = experiment.schedule.steps[visit.step].positions[0];
        for _ in &visit.readings {
            assert!((target[row] - machine[row]).abs() < TURNED_MM);
            if (angle - std::f64::consts::PI).abs() < 1e-9 {
                assert!((turned[row] - back[row]).abs() < TURNED_MM);
            }
            row += 1;
        }
    }
}
