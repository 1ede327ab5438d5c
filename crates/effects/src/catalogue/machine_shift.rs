//! A sudden shift of the tool against the bed at t0: `D_p = d · [t > t0]`.
//!
//! d is `shift_x`, `shift_y`, `shift_z` in µm, in the reference frame.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "machine_shift",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::all_alike,
    parameters: |_, _| Parameter::vector("shift", "um"),
    shape: Shape::Instant,
    form: Form::Target(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the machine shifted: referencing, a collision, an axis that was switched off, a clamp that let go",
        consequence: "points before and after it do not belong to one machine",
        action: "find what happened at this instant, reference the machine again, measure again",
        separate_by: "read fixed points on the bed (three targets, if by a tracker) before and after: their readings stay if the machine shifted, and jump if the instrument or its tripod was bumped",
    },
};
