//! The positioning error of a linear axis grows in proportion to position: `s q`.

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, MotionError};

use crate::PPM;
use crate::curve::curve_form;
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Subject,
};

#[derive(Debug)]
pub(super) struct ScaleError;

impl Effect for ScaleError {
    fn id(&self) -> &'static str {
        "scale_error"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let axes = scene.moving_axes(AxisKind::Linear);
        axes.map(Subject::axis).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("scale", "ppm")]
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

    fn motion(&self, _: &Subject, _: usize, _: f64, at: &AxisPosition<'_>) -> MotionError {
        let along = at.axis.direction().into_inner();
        MotionError::new(along * (PPM * at.position), Vector3::zeros())
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the length standard of the axis is off: pitch of the screw, temperature or mounting of the scale, its tilt against the way, a wrong compensation factor; or all lengths of the instrument are off in scale",
            consequence: "every length that the axis makes is wrong in proportion",
            action: "check the temperature of the scale and the coefficient of expansion that was assumed, then enter the factor in the control",
            separate_by: "all axes off by the same amount point to the instrument's length scale: measure one line with another interferometer or a calibrated step gauge",
        }
    }
}
