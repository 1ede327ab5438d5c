//! The error of a machine between two steps of its only axis.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{Axis, LocationError, Machine, MotionError};
use trueaxis_predict::{CalibratedMachine, FactoredCovariance, MeasuredAxis, Node};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let x = Axis::linear("X", Vector3::x(), [0.0, 400.0])?;
    let machine = Machine::new(vec![x], vec![0], vec![])?;
    // Measured at two steps: at the second X goes 8 µm too far. `CalibratedMachine::read` takes all from files.
    let nodes = [0.0, 400.0].map(|position| Node {
        position,
        direction: None,
    });
    let errors = [0.0, 0.008].map(|mm| MotionError::new(Vector3::x() * mm, Vector3::zeros()));
    let axis = MeasuredAxis {
        axis: 0,
        nodes: nodes.to_vec(),
        errors: errors.to_vec(),
        location: LocationError::default(),
        reported: vec![],
    };
    let machine = CalibratedMachine::new(machine, vec![axis], FactoredCovariance::zero(2, 12));
    let there = machine.predict(&[100.0], Point3::origin());
    let e_um = there.error.translation_mm.x * 1e3;
    println!("at X = 100 mm the tool is {e_um:.1} µm too far");
    assert!((e_um - 2.0).abs() < 1e-9 && !there.extrapolated);
    Ok(())
}
