//! The beam is interrupted at t0: the zero of the interferometer jumps, `D_l = a · [t > t0, this station]`.
//!
//! a is `jump` in µm; a positive one makes lengths longer.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "dead_path_jump",
    layer: Layer::Instrument,
    levels: &[Level::Lengths],
    subjects: Subject::each_station,
    parameters: |_, _| vec![Parameter::new("jump", "um")],
    shape: Shape::Instant,
    form: Form::Length(|_| MICROMETRE),
    explanation: Explanation {
        cause: "the beam of this station was interrupted, or the interferometer lost counts: its zero jumped",
        consequence: "all lengths of the station after it are off by the same amount",
        action: "give the station a new zero from this instant (calibrate does so on its own), or measure the rest of the occupation again",
        separate_by: "read a fixed target on the bed before and after: a jump of the zero shows there, too, whatever its direction",
    },
};
