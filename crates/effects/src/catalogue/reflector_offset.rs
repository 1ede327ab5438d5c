//! The constant of a target's reflector is not the declared one: `D_l = a`, this target.
//!
//! a is `offset` in µm; a positive one makes lengths longer. The constant of each reflector is an unknown of the
//! adjustment, so that it shows only where targets are declared to share a reflector and do not.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "reflector_offset",
    layer: Layer::Setup,
    levels: &[Level::Lengths],
    subjects: Subject::each_target,
    parameters: |_, _| vec![Parameter::new("offset", "um")],
    shape: Shape::Fixed,
    form: Form::Length(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the constant of this target's reflector is not the one that it was declared to share: another reflector, or another seat in the nest",
        consequence: "one constant ties targets that have two: results are off by several times the difference",
        action: "declare which reflector was in which nest (`reflector` of the targets), so that each constant is an unknown",
        separate_by: "read one nest with both reflectors, one after the other",
    },
};
