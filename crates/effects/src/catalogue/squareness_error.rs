//! Two linear axes that are not square to each other, beyond what the calibration says: the later axis
//! is turned by the angle, `D_p = q α R (n × e)`; α is `squareness` in arcsec.
//!
//! `e` is the direction of the axis and `n` the common perpendicular of the two axes at home, on the side of the
//! positive reference axis, so that the parameter has the sign of the ISO 230-1 location errors: for Y against X it is a
//! change of `C0Y` (direction `(-C0Y, 1, 0)`), for Z against X of `B0Z`, for Z against Y of `A0Z`. `R` is the
//! orientation of what carries the axis: behind a rotary axis the error turns with it.

use nalgebra::Vector3;
use trueaxis_kinematics::ARCSEC;

use crate::form::AtReading;
use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "squareness_error",
    layer: Layer::Machine,
    levels: &[Level::Verification],
    subjects: |scene| {
        let pairs = scene.linear_pairs().into_iter();
        pairs.map(|(a, b)| Subject::pair(b, a)).collect()
    },
    parameters: |_, _| vec![Parameter::new("squareness", "arcsec")],
    shape: Shape::Fixed,
    form: Form::Displacement(turned),
    explanation: Explanation {
        cause: "the average lines of the two axes are not at the angle that the model has: levelling, foundation, a collision, or a calibration that is out of date",
        consequence: "every plane that the two axes span is sheared; the squareness of the calibration is off by this amount",
        action: "level the machine and measure again; else correct the squareness in the control",
        separate_by: "run the ball bar in both senses of rotation and at another place: squareness stays, a servo mismatch changes sign, bending under load grows from the corner",
    },
};

/// `q α R n × e` for α = 1 arcsec, mm.
fn turned(of: &AtReading<'_>) -> Vector3<f64> {
    let (Some(axis), Some(other)) = (of.subject.axis, of.subject.other_axis) else {
        return Vector3::zeros();
    };
    if !of.at.is_carried_by(axis) {
        return Vector3::zeros();
    }
    let direction = |axis: usize| of.at.machine.axes()[axis].direction().into_inner();
    let (along, reference) = (direction(axis), direction(other));
    // Parallel axes have no common perpendicular.
    let Some(normal) = reference.cross(&along).try_normalize(f64::EPSILON) else {
        return Vector3::zeros();
    };
    let side = normal[normal.iamax()].signum();
    let ref_from_base = of.at.ref_from_base(axis).rotation;
    ref_from_base * normal.cross(&along) * (side * ARCSEC * of.position())
}
