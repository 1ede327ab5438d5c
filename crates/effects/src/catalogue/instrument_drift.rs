//! The zero of the instrument that takes verification readings drifts: a reading grows by `rate · τ`.
//!
//! `rate` is in µm over the readings, from the first to the last; a positive one makes readings larger.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "instrument_drift",
    layer: Layer::Instrument,
    levels: &[Level::Verification],
    subjects: Subject::all_alike,
    parameters: |_, _| vec![Parameter::new("rate", "um")],
    shape: Shape::Fixed,
    form: Form::Length(|of| MICROMETRE * of.at.progress),
    explanation: Explanation {
        cause: "the zero of the instrument that took these readings drifts: its mount, its electronics or the air in its dead path",
        consequence: "the readings see a drift that the machine may not have",
        action: "let the instrument warm up on its mount, shorten its dead path, read a fixed point on the bed at the start and at the end",
        separate_by: "stop the machine and go on reading: the drift of an instrument does not stop; or read the same motion with a second instrument",
    },
};
