//! The graduated disc of a rotary axis is not round or not flat: two waves per turn of the angle about
//! the axis, `s sin 2q + c cos 2q`.

use trueaxis_kinematics::{ARCSEC, AxisKind, MotionError};

use crate::curve::{about_itself, curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Subject,
};

#[derive(Debug)]
pub(super) struct EncoderEllipticity;

impl Effect for EncoderEllipticity {
    fn id(&self) -> &'static str {
        "encoder_ellipticity"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let axes = scene.moving_axes(AxisKind::Rotary);
        axes.map(Subject::axis).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        ["sine", "cosine"]
            .map(|name| Parameter::new(name, "arcsec"))
            .into()
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        curve_form(self, subject, parameter, shape, at)
    }

    fn motion(&self, _: &Subject, parameter: usize, _: f64, at: &AxisPosition<'_>) -> MotionError {
        about_itself(
            at.axis,
            ARCSEC * sine_or_cosine(parameter, 2.0 * at.position),
        )
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the disc of the encoder is clamped out of round or tilted, or two opposite heads do not sit opposite",
            consequence: "the angle of the axis is off by two waves per turn; two opposite heads do not cancel it",
            action: "loosen and clamp the disc again, check its axial run-out; else compensate with a table over a full turn",
            separate_by: "compare with an angle standard (autocollimator and polygon) before and after clamping the disc again",
        }
    }
}
