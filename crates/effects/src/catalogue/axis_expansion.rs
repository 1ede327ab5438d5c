//! The scale of an axis grows: `α τ q` along the axis (linear axes).

use crate::PPM;
use crate::axis_at::unit_motion;
use trueaxis_kinematics::AxisKind;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct AxisExpansion;

impl Effect for AxisExpansion {
    fn id(&self) -> &'static str {
        "axis_expansion"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        scene
            .moving_axes(AxisKind::Linear)
            .map(Subject::axis)
            .collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("expansion", "ppm")]
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        let Some(axis) = subject.axis else {
            return Displaced::default();
        };
        let position = at.positions.get(axis).copied().unwrap_or(0.0);
        Displaced::point(unit_motion(axis, at) * (PPM * at.progress * position))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the screw or the scale of the axis warms up and grows: steel 11 ppm per K",
            consequence: "the positioning error of the axis is that of no single instant",
            action: "warm the axis up before measuring, log the temperature of its scale, compensate thermally",
            separate_by: "measure the axis at the start and at the end of the campaign, with the temperature of its scale",
        }
    }
}
