//! The stage is not rigid: a target moves against the others with the position of an axis, `D_p = c q²`, c
//! fixed in the stage.
//!
//! c is `bending_x`, `bending_y`, `bending_z` in µm/m², for a rotary axis in µm/rad², along the reference
//! directions when the stage is at home.

use trueaxis_kinematics::{Axis, AxisKind, MICROMETRE};

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Scene, Shape, Subject};

const METRES_PER_MM: f64 = 1e-3;

pub(super) const EFFECT: Effect = Effect {
    id: "stage_bending",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points],
    subjects: each_axis_of_each_target,
    parameters: |scene, subject| {
        Parameter::vector("bending", scene.unit(subject, "um/m2", "um/rad2"))
    },
    shape: Shape::Fixed,
    form: Form::TargetOnStage(|of| {
        let q = match of.axis().map(Axis::kind) {
            Some(AxisKind::Linear) => of.position() * METRES_PER_MM,
            _ => of.position(),
        };
        MICROMETRE * q * q
    }),
    explanation: Explanation {
        cause: "the stage bends as it moves (guideway, weight, clamping), so that this target moves against the others",
        consequence: "three targets on a stage that is not rigid give wrong angular errors",
        action: "mount the targets on one stiff plate, or include the bending in the model of the machine",
        separate_by: "put a fourth target on the stage: it shows which target moves",
    },
};

/// Each target with each moving axis that carries it.
fn each_axis_of_each_target(scene: &Scene) -> Vec<Subject> {
    let targets = scene.targets.iter().enumerate();
    let of_target = targets.flat_map(|(target, content)| {
        let chain = scene.machine.chain(content.carrier);
        let moving = scene.moving.iter().filter(|axis| chain.contains(axis));
        moving.map(move |&axis| Subject {
            target: Some(target),
            ..Subject::axis(axis)
        })
    });
    of_target.collect()
}
