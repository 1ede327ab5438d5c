//! The time stamps of the readings are late while the machine moves on: `v Δt` along the axis that moves.
//!
//! Δt is `offset` in ms; with a positive one the axis is further on than its position says.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

const SECONDS_PER_MS: f64 = 1e-3;

pub(super) const EFFECT: Effect = Effect {
    id: "timestamp_offset",
    layer: Layer::Instrument,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::each_axis,
    parameters: |_, _| vec![Parameter::new("offset", "ms")],
    shape: Shape::Fixed,
    form: Form::Delay(SECONDS_PER_MS),
    explanation: Explanation {
        cause: "readings are taken on the fly and their time stamps do not belong to the positions; on a circle the servo of this axis lags more than that of the other one",
        consequence: "looks like lost motion in proportion to the feed",
        action: "synchronise the trigger, or measure at standstill; on a circle match the position gains of both axes",
        separate_by: "measure the same line at another feed: a time offset grows with the feed, lost motion does not",
    },
};
