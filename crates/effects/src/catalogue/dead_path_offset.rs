//! A constant offset of all lengths of a station, `D_l = a`. The dead path absorbs it, so no length shows it.
//!
//! a is `offset` in µm; a positive one makes lengths longer.

use crate::{Effect, Explanation, Form, Layer, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "dead_path_offset",
    layer: Layer::Instrument,
    levels: &[],
    subjects: Subject::each_station,
    parameters: |_, _| vec![Parameter::new("offset", "um")],
    shape: Shape::Fixed,
    form: Form::Length(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the interferometer's zero is off by a constant",
        consequence: "none: the dead path of the station absorbs it",
        action: "nothing",
        separate_by: "compare the dead path with an absolute distance",
    },
};
