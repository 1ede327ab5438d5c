//! Effects that are a part of an error curve.
//!
//! Such an effect says what it adds to the component errors of its axis ([`Effect::motion`]). What that
//! does to a reading follows for all of them alike: the stage moves by δ and turns by ε about the
//! reference point of δ,
//!
//! ```text
//! D = R (δ + ε × r)        r = p - o - q d  (linear)        r = p - o  (rotary)
//! ```
//!
//! with p the point where it stands, o the reference point and d the direction of the axis, all in the
//! frame of what carries the axis, and R the orientation of that frame, from the commanded positions.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{Axis, AxisKind, Ideal, MotionError};

use crate::{Circumstances, Displaced, Effect, Subject};

/// A position of an axis on an error curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPosition<'a> {
    /// The axis.
    pub axis: &'a Axis,
    /// Commanded position, mm or rad.
    pub position: f64,
    /// Side of approach, +1 or -1.
    pub direction: f64,
}

/// [`Effect::form`] of an effect that is a part of an error curve.
pub(crate) fn curve_form(
    effect: &dyn Effect,
    subject: &Subject,
    parameter: usize,
    shape: f64,
    at: &Circumstances<'_>,
) -> Displaced {
    let Some(axis) = subject.axis.filter(|&axis| at.is_carried_by(axis)) else {
        return Displaced::default();
    };
    let content = &at.machine.axes()[axis];
    let place = AxisPosition {
        axis: content,
        position: at.positions.get(axis).copied().unwrap_or(0.0),
        direction: at.direction,
    };
    let motion = effect.motion(subject, parameter, shape, &place);
    // The chain up to the axis, which moves on what lies before it.
    let chain = at.machine.chain(axis);
    let before = &chain[..chain.len() - 1];
    let ref_from_base = at.machine.chain_motion(&Ideal, before, at.positions);
    let point: Point3<f64> = ref_from_base.inverse() * at.point_mm;
    let reference = content.reference_mm();
    let reference = match content.kind() {
        AxisKind::Linear => reference + content.direction().into_inner() * place.position,
        AxisKind::Rotary => reference,
    };
    Displaced::point(ref_from_base.rotation * motion.displacement_mm(point - reference))
}

/// A rotation about the direction of an axis.
pub(crate) fn about_itself(axis: &Axis, angle_rad: f64) -> MotionError {
    MotionError::new(Vector3::zeros(), axis.direction().into_inner() * angle_rad)
}

/// The two reference directions (0, 1, 2 for x, y, z) across an axis, in this order.
pub(crate) fn across(axis: &Axis) -> [usize; 2] {
    match axis.principal() {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

/// `sin` for parameter 0, `cos` for parameter 1 of an angle in rad.
pub(crate) fn sine_or_cosine(parameter: usize, angle_rad: f64) -> f64 {
    if parameter == 0 {
        angle_rad.sin()
    } else {
        angle_rad.cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect;
    use nalgebra::UnitQuaternion;
    use trueaxis_kinematics::{ARCSEC, GeometricErrors, LocationError, Machine};

    /// Component errors of one axis from an effect.
    struct Curve<'a> {
        effect: &'a dyn Effect,
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
            (
                "guideway_bow",
                Subject::component(2, trueaxis_kinematics::Component::Z),
                0.0,
            ),
            (
                "cyclic_error",
                Subject::component(2, trueaxis_kinematics::Component::A),
                50.0,
            ),
        ];
        for (id, subject, shape) in cases {
            let effect = effect(id).unwrap();
            let at = Circumstances {
                positions: &positions,
                carrier: 2,
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
}
