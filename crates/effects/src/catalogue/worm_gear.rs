//! The worm of a rotary axis: n waves per turn of the angle about the axis, `s sin nq + c cos nq`.
//!
//! n is the number of revolutions of the worm in one turn of the axis, or a multiple of it; one and two
//! waves per turn belong to the encoder's disc.

use trueaxis_kinematics::{ARCSEC, AxisKind, MotionError};

use crate::curve::{about_itself, curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Shape, Subject,
};

#[derive(Debug)]
pub(super) struct WormGear;

impl Effect for WormGear {
    fn id(&self) -> &'static str {
        "worm_gear"
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

    fn shape(&self) -> Shape {
        Shape::Waves
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

    fn motion(
        &self,
        _: &Subject,
        parameter: usize,
        shape: f64,
        at: &AxisPosition<'_>,
    ) -> MotionError {
        about_itself(
            at.axis,
            ARCSEC * sine_or_cosine(parameter, shape * at.position),
        )
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the worm or pinion of the drive runs out, or its teeth differ: the error repeats with every revolution of the worm",
            consequence: "between two measured angles the error is not on the straight line that a compensation table draws",
            action: "compare the number of waves with the ratio of the gear; check the worm's run-out and bearing; compensate with at least eight points per wave",
            separate_by: "measure one or two waves with a step of an eighth of a wave: more waves than the step can show appear as fewer",
        }
    }
}
