//! The stage is not rigid: a target moves against the others with the position of an axis, `u·c · q²`, c fixed in the stage.

use nalgebra::Vector3;
use trueaxis_kinematics::{AxisKind, MICROMETRE};

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

const METRES_PER_MM: f64 = 1e-3;

#[derive(Debug)]
pub(super) struct StageBending;

impl Effect for StageBending {
    fn id(&self) -> &'static str {
        "stage_bending"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let mut subjects = Vec::new();
        for (target, content) in scene.targets.iter().enumerate() {
            let chain = scene.machine.chain(content.carrier);
            let moving = scene.moving.iter().filter(|axis| chain.contains(axis));
            subjects.extend(moving.map(|&axis| Subject {
                target: Some(target),
                ..Subject::axis(axis)
            }));
        }
        subjects
    }

    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        let rotary = subject
            .axis
            .is_some_and(|axis| scene.machine.axes()[axis].kind() == AxisKind::Rotary);
        let unit = if rotary { "um/rad2" } else { "um/m2" };
        ['x', 'y', 'z']
            .map(|axis| Parameter::new(format!("bending_{axis}"), unit))
            .into()
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        let (Some(axis), true) = (subject.axis, subject.has_target(at.target)) else {
            return Displaced::default();
        };
        let position = at.positions.get(axis).copied().unwrap_or(0.0);
        let q = match at.machine.axes()[axis].kind() {
            AxisKind::Linear => position * METRES_PER_MM,
            AxisKind::Rotary => position,
        };
        Displaced::point(at.ref_from_stage() * Vector3::ith(parameter, MICROMETRE * q * q))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the stage bends as it moves (guideway, weight, clamping), so that this target moves against the others",
            consequence: "three targets on a stage that is not rigid give wrong angular errors",
            action: "mount the targets on one stiff plate, take the bending into the model of the machine",
            separate_by: "put a fourth target on the stage: it tells which target moves",
        }
    }
}
