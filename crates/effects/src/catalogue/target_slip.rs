//! A target moves in its nest at t0: `u·d · [t > t0, this target]`, d fixed in its stage.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Shape, Subject,
};

#[derive(Debug)]
pub(super) struct TargetSlip;

impl Effect for TargetSlip {
    fn id(&self) -> &'static str {
        "target_slip"
    }

    fn layer(&self) -> Layer {
        Layer::Setup
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        (0..scene.targets.len()).map(Subject::target).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        Parameter::vector_um("slip")
    }

    fn shape(&self) -> Shape {
        Shape::Instant
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        if !subject.has_target(at.target) {
            return Displaced::default();
        }
        Displaced::point(at.ref_from_stage() * Vector3::ith(parameter, MICROMETRE))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the target slipped in its nest (touched, clamped badly, dirt under it)",
            consequence: "the triangle of targets is another one from then on: angular errors of all axes measured later are off",
            action: "clean and clamp the target, measure again from the instant on",
            separate_by: "measure the three distances between the targets before and after, or put a fourth target on the stage",
        }
    }
}
