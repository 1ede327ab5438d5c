//! A target drifts: `u·v · τ`, v fixed in its stage.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct TargetCreep;

impl Effect for TargetCreep {
    fn id(&self) -> &'static str {
        "target_creep"
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
        Parameter::vector_um("creep")
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
        Displaced::point(at.ref_from_stage() * Vector3::ith(parameter, MICROMETRE * at.progress))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the holder of the target gives way (magnet, glue, thermal expansion)",
            consequence: "the triangle of targets changes slowly: angular errors of axes measured late are off",
            action: "mount the target stiffly, let it settle, measure again",
            separate_by: "measure the three distances between the targets at the start and the end",
        }
    }
}
