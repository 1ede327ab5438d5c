//! The graduated disc of a rotary axis is off centre: one wave per turn of the angle about the axis,
//! `s sin q + c cos q`.
//!
//! With the centre of the disc e away from the axis and graduation lines on the radius ρ the amplitude is
//! e/ρ: 1 µm on 50 mm gives 4.1 arcsec.

use trueaxis_kinematics::{ARCSEC, AxisKind, MotionError};

use crate::curve::{about_itself, curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Subject,
};

#[derive(Debug)]
pub(super) struct EncoderEccentricity;

impl Effect for EncoderEccentricity {
    fn id(&self) -> &'static str {
        "encoder_eccentricity"
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
        about_itself(at.axis, ARCSEC * sine_or_cosine(parameter, at.position))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the disc of the encoder (or the gear that drives it) is not centred on the axis",
            consequence: "the angle of the axis is off by a full wave per turn; opposite positions have opposite errors",
            action: "centre the disc, or read it with two opposite heads, which cancels it; else compensate with a table over a full turn",
            separate_by: "compare with an angle standard (autocollimator and polygon) started at two positions of the polygon: what stays with the axis is the encoder",
        }
    }
}
