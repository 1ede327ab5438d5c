//! Exact motions: composition, rigidity, and the first order of everything.

use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use trueaxis_kinematics::{Axis, LocationError, MotionError};

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

fn direction() -> impl Strategy<Value = Vector3<f64>> {
    vector(1.0)
        .prop_filter("long enough to have a direction", |v| v.norm() > 0.1)
        .prop_map(|v| v.normalize())
}

fn axis() -> impl Strategy<Value = Axis> {
    (direction(), vector(500.0), any::<bool>()).prop_map(|(direction, point, rotary)| {
        if rotary {
            Axis::rotary("R", direction, [-7.0, 7.0], Point3::from(point)).unwrap()
        } else {
            Axis::linear("L", direction, [-7.0, 7.0]).unwrap()
        }
    })
}

fn location() -> impl Strategy<Value = LocationError> {
    // No shift: one along the axis lifts the stage at every position, so motions would not add.
    vector(1e-3).prop_map(|tilt_rad| LocationError {
        offset_mm: Vector3::zeros(),
        tilt_rad,
    })
}

proptest! {
    #[test]
    fn commanded_motions_of_an_axis_add(
        axis in axis(), location in location(), a in -3.0..3.0, b in -3.0..3.0, p in vector(500.0)
    ) {
        let p = Point3::from(p);
        let one_by_one = axis.commanded_motion(a, &location) * (axis.commanded_motion(b, &location) * p);
        let at_once = axis.commanded_motion(a + b, &location) * p;
        prop_assert!((one_by_one - at_once).norm() < 1e-9);
    }

    #[test]
    fn motions_are_rigid(
        axis in axis(), location in location(), q in -6.0..6.0,
        delta in vector(0.1), epsilon in vector(1e-3), p in vector(500.0), r in vector(500.0)
    ) {
        let motion = axis.motion(q, &location, &MotionError::new(delta, epsilon));
        let (p, r) = (Point3::from(p), Point3::from(r));
        prop_assert!(((motion * p - motion * r).norm() - (p - r).norm()).abs() < 1e-9);
    }

    /// Component errors displace a point by `δ + ε × r`, r relative to the moved reference point.
    #[test]
    fn component_errors_act_at_the_reference_point(
        axis in axis(), location in location(), q in -6.0..6.0,
        delta in vector(0.01), epsilon in vector(1e-5), p in vector(500.0)
    ) {
        let error = MotionError::new(delta, epsilon);
        let p = Point3::from(p);
        let commanded = axis.commanded_motion(q, &location);
        let lever = commanded * p - commanded * axis.reference_at_home_mm(&location);
        let displacement = axis.motion(q, &location, &error) * p - commanded * p;
        let second_order = epsilon.norm_squared() * lever.norm() + 1e-10;
        prop_assert!((displacement - error.displacement_mm(lever)).norm() < second_order);
    }
}
