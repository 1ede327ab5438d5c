//! A target drifts: `D_p = v · τ`, v fixed in its stage.
//!
//! v is `creep_x`, `creep_y`, `creep_z` in µm over the campaign, along the reference directions when the stage
//! is at home.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "target_creep",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::each_target,
    parameters: |_, _| Parameter::vector("creep", "um"),
    shape: Shape::Fixed,
    form: Form::TargetOnStage(|of| MICROMETRE * of.at.progress),
    explanation: Explanation {
        cause: "the holder of the target gives way (magnet, glue, thermal expansion)",
        consequence: "the triangle of targets changes slowly: angular errors of axes measured late are off",
        action: "mount the target stiffly, let it settle, measure again",
        separate_by: "measure the three distances between the targets at the start and the end",
    },
};
