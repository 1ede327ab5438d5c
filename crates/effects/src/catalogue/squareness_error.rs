//! Two linear axes that are not square to each other, beyond what the calibration says: the later axis
//! is turned by the angle, `q α n × e`.
//!
//! `n` is the common perpendicular of the two axes on the side of the positive reference axis, so that
//! the parameter has the sign of the ISO 230-1 location errors: for Y against X it is a change of
//! `C0Y` (direction `(-C0Y, 1, 0)`), for Z against X of `B0Z`, for Z against Y of `A0Z`.

use crate::axis_at::unit_motion;
use trueaxis_kinematics::{ARCSEC, AxisKind};

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct SquarenessError;

impl Effect for SquarenessError {
    fn id(&self) -> &'static str {
        "squareness_error"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let mut linear: Vec<usize> = scene.moving_axes(AxisKind::Linear).collect();
        linear.sort_unstable();
        let pairs = linear
            .iter()
            .enumerate()
            .flat_map(|(i, &a)| linear[i + 1..].iter().map(move |&b| (b, a)));
        pairs
            .map(|(axis, other)| Subject {
                other_axis: Some(other),
                ..Subject::axis(axis)
            })
            .collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("squareness", "arcsec")]
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        let (Some(axis), Some(other)) = (subject.axis, subject.other_axis) else {
            return Displaced::default();
        };
        let (along, reference) = (unit_motion(axis, at), unit_motion(other, at));
        // Parallel axes, or one that does not move the target, have no common perpendicular.
        let Some(normal) = reference.cross(&along).try_normalize(f64::EPSILON) else {
            return Displaced::default();
        };
        let side = normal[normal.iamax()].signum();
        let position = at.positions.get(axis).copied().unwrap_or(0.0);
        Displaced::point(normal.cross(&along) * (side * ARCSEC * position))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the average lines of the two axes are not at the angle that the model has: levelling, foundation, a collision, or a calibration that is out of date",
            consequence: "every plane that the two axes span is sheared; the squareness of the calibration is off by this amount",
            action: "level the machine and measure again; else correct the squareness in the control",
            separate_by: "run the ball bar in both senses of rotation and at another place: squareness stays, a servo mismatch turns its sign, bending under load grows from the corner",
        }
    }
}
