//! The zero of the instrument that takes verification readings jumps at t0: `a · [t > t0]`.
//!
//! a is `jump` in µm; a positive one makes readings larger.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "instrument_jump",
    layer: Layer::Instrument,
    levels: &[Level::Verification],
    subjects: Subject::all_alike,
    parameters: |_, _| vec![Parameter::new("jump", "um")],
    shape: Shape::Instant,
    form: Form::Length(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the zero of the instrument that took these readings jumped: lost counts, a knock against its mount, a new zero",
        consequence: "readings before and after it do not belong together",
        action: "find what happened at this instant, set the zero again and repeat the readings after it",
        separate_by: "read a fixed point on the bed before and after: it jumps with the instrument, and stays when the machine shifted",
    },
};
