//! Effects that are a part of an error curve.

use nalgebra::{Point3, UnitQuaternion, Vector3};
use trueaxis_effects::{AxisPosition, Circumstances, Effect, Subject, effect};
use trueaxis_kinematics::{
    ARCSEC, Axis, Component, GeometricErrors, Ideal, LocationError, Machine, MotionError,
};

/// Component errors of one axis from an effect.
struct Curve<'a> {
    effect: &'a Effect,
    subject: Subject,
    shape: f64,
    machine: &'a Machine,
}

impl GeometricErrors for Curve<'_> {
    fn location(&self, _: usize) -> LocationError {
        LocationError::default()
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        if Some(axis) != self.subject.axis {
            return MotionError::default();
        }
        let at = AxisPosition {
            axis: &self.machine.axes()[axis],
            position,
            direction: 1.0,
        };
        self.effect.motion(&self.subject, 0, self.shape, &at)
    }
}

/// The displacement is the first order of what the exact model of the machine does with the same
/// curve, behind another axis that has moved.
#[test]
fn agrees_with_the_model_of_the_machine() {
    let point = Point3::new(5.0, -7.0, 11.0);
    let turn = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5);
    let axes = vec![
        Axis::rotary("A", Vector3::x(), [0.0, 6.0], Point3::new(0.0, 9.0, -4.0)),
        Axis::rotary("C", turn * Vector3::z(), [0.0, 6.0], point),
        Axis::linear("Y", Vector3::y(), [0.0, 400.0]),
    ];
    let axes: Vec<Axis> = axes.into_iter().map(Result::unwrap).collect();
    let machine = Machine::new(axes, vec![0, 1, 2], vec![]).unwrap();
    let positions = [0.7, 2.1, 130.0];
    let home = Point3::new(120.0, 80.0, -60.0);
    let cases = [
        ("encoder_eccentricity", Subject::axis(1), 0.0),
        ("axis_wobble", Subject::axis(1), 2.0),
        ("axis_runout", Subject::axis(1), 3.0),
        ("scale_error", Subject::axis(2), 0.0),
        ("guideway_bow", Subject::component(2, Component::Z), 0.0),
        ("cyclic_error", Subject::component(2, Component::A), 50.0),
    ];
    for (id, subject, shape) in cases {
        let effect = effect(id).unwrap();
        let at = Circumstances {
            positions: &positions,
            carrier: Some(2),
            point_mm: machine.position(&Ideal, 2, &positions, home),
            ..Circumstances::new(&machine)
        };
        let found = effect.form(&subject, 0, shape, &at).point_mm;
        let errors = Curve {
            effect,
            subject,
            shape,
            machine: &machine,
        };
        let exact = machine.position(&errors, 2, &positions, home) - at.point_mm;
        assert!(found.norm() > 1e-6, "{id}");
        // Second order: at most the square of the largest angle, a few arcsec, times the lever.
        let second_order_mm = (5.0 * ARCSEC).powi(2) * 300.0;
        assert!(
            (found - exact).norm() < second_order_mm,
            "{id} {found} {exact}"
        );
    }
}

/// The table of signs, each angle as the difference quotient of its straightness.
#[test]
fn the_angle_is_the_slope_of_the_straightness_by_the_right_hand_rule() {
    let guideway_bow = effect("guideway_bow").unwrap();
    // Axis, straightness, angle, sign.
    let table = [
        (0, 1, 2, 1.0),
        (0, 2, 1, -1.0),
        (1, 0, 2, -1.0),
        (1, 2, 0, 1.0),
    ];
    for (axis, straightness, angle, sign) in
        table.into_iter().chain([(2, 0, 1, 1.0), (2, 1, 0, -1.0)])
    {
        let content = Axis::linear("L", Vector3::ith(axis, 1.0), [-200.0, 400.0]).unwrap();
        let subject = Subject::component(0, Component::ALL[straightness]);
        let motion = |position| {
            let at = AxisPosition {
                axis: &content,
                position,
                direction: 1.0,
            };
            guideway_bow.motion(&subject, 0, 0.0, &at)
        };
        let (before, after) = (motion(149.0).translation_mm, motion(151.0).translation_mm);
        let slope = (after - before)[straightness] / 2.0;
        assert!(slope > 0.0);
        let expected = Vector3::ith(angle, sign * slope);
        assert!((motion(150.0).rotation_rad - expected).norm() < 1e-6 * slope);
    }
}

/// C0Y leans Y to (-α, 1, 0) at home, whatever turns between X and Y, and whatever X carries.
#[test]
fn squareness_is_that_of_the_axes_at_home() {
    let axis = |name, direction| Axis::linear(name, direction, [0.0, 400.0]).unwrap();
    let turn = |name, direction| Axis::rotary(name, direction, [-7.0, 7.0], Point3::origin());
    let (x, y) = (axis("X", Vector3::x()), axis("Y", Vector3::y()));
    let c = turn("C", Vector3::z()).unwrap();
    let b = turn("B", Vector3::y()).unwrap();
    let (sin, cos) = 0.5_f64.sin_cos();
    let quarter = std::f64::consts::FRAC_PI_2;
    let subject = Subject {
        other_axis: Some(0),
        ..Subject::axis(1)
    };
    let cases = [
        (Some(&c), 0.0, [-1.0, 0.0, 0.0]),
        (Some(&c), quarter, [0.0, -1.0, 0.0]),
        (Some(&c), 2.0 * quarter, [1.0, 0.0, 0.0]),
        (Some(&b), 0.5, [-cos, 0.0, sin]),
        // X moves the table.
        (None, 0.0, [-1.0, 0.0, 0.0]),
    ];
    for (between, angle, leans) in cases {
        let axes = [x.clone(), y.clone()].into_iter().chain(between.cloned());
        let tool = between.map_or(vec![1], |_| vec![0, 2, 1]);
        let table = between.map_or(vec![0], |_| vec![]);
        let machine = Machine::new(axes.collect(), tool, table).unwrap();
        for y_mm in [0.0, 150.0, -60.0] {
            let positions = [30.0, y_mm, angle];
            let at = Circumstances {
                positions: &positions[..machine.axes().len()],
                carrier: Some(1),
                point_mm: Point3::new(70.0, 20.0, 90.0),
                ..Circumstances::new(&machine)
            };
            let squareness_error = effect("squareness_error").unwrap();
            let found = squareness_error.form(&subject, 0, 0.0, &at);
            let expected = Vector3::from(leans) * (y_mm * ARCSEC);
            let off_mm = (found.point_mm - expected).norm();
            assert!(off_mm < 1e-12, "{angle} {y_mm}: {}", found.point_mm);
        }
    }
}
