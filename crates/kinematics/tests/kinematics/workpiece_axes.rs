//! The worked examples of axes that move the workpiece (docs/conventions.md).

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{
    ARCSEC, Axis, GeometricErrors, LocationError, MICROMETRE, Machine, MotionError,
};

/// The same component errors at every position.
struct Constant(MotionError);

impl GeometricErrors for Constant {
    fn location(&self, _: usize) -> LocationError {
        LocationError::default()
    }

    fn motion(&self, _: usize, _: f64) -> MotionError {
        self.0
    }
}

fn at_tool(table: Axis, position: f64, error: MotionError, tool_mm: Point3<f64>) -> MotionError {
    let machine = Machine::new(vec![table], vec![], vec![0]).unwrap();
    machine.tool_error(&Constant(error), &[position], tool_mm)
}

#[test]
fn a_table_that_moves_to_the_left() {
    let table = Axis::linear("X", -Vector3::x(), [0.0, 500.0]).unwrap();
    let right = MotionError::new(Vector3::x() * 5.0 * MICROMETRE, Vector3::zeros());
    let found = at_tool(table, 100.0, right, Point3::new(10.0, 20.0, 30.0));
    let expected_mm = -Vector3::x() * 5.0 * MICROMETRE;
    assert!((found.translation_mm - expected_mm).norm() < 1e-12);
    assert!(found.rotation_rad.norm() < 1e-15);
}

#[test]
fn a_table_that_turns_too_far() {
    let table = Axis::rotary("C", Vector3::z(), [0.0, 6.0], Point3::origin()).unwrap();
    let turned = MotionError::new(Vector3::zeros(), Vector3::z() * 10.0 * ARCSEC);
    let found = at_tool(table, 0.0, turned, Point3::new(200.0, 0.0, 0.0));
    let along_y_um = found.translation_mm.y / MICROMETRE;
    assert!((along_y_um + 9.70).abs() < 0.005, "{along_y_um}");
    assert!(found.translation_mm.x.abs() < 1e-6 && found.translation_mm.z == 0.0);
    assert!((found.rotation_rad.z / ARCSEC + 10.0).abs() < 1e-9);
}
