//! A target moves in its nest at t0: `D_p = d · [t > t0, this target]`, d fixed in its stage.
//!
//! d is `slip_x`, `slip_y`, `slip_z` in µm, along the reference directions when the stage is at home.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "target_slip",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::each_target,
    parameters: |_, _| Parameter::vector("slip", "um"),
    shape: Shape::Instant,
    form: Form::TargetOnStage(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the target slipped in its nest (touched, clamped badly, dirt under it)",
        consequence: "the triangle of targets has a different shape from then on: angular errors of all axes measured later are off",
        action: "clean and clamp the target, measure again from that instant on",
        separate_by: "measure the three distances between the targets before and after, or put a fourth target on the stage",
    },
};
