//! The axis of rotation moves sideways n times per turn: `s sin nq + c cos nq` along the two reference
//! directions across the axis (x and y for C), `sine_x` and so on in µm; n is `waves`.
//!
//! Of one wave per turn the average axis and the mounting of the targets take the part that turns with
//! the stage, `(cos q, sin q)` and `(-sin q, cos q)`; what is left turns against it. From two waves
//! per turn on all of it is seen.

use crate::waves::{SHIFTS, parameters_across};
use crate::{Effect, Explanation, Form, Layer, Level, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "axis_runout",
    layer: Layer::Machine,
    levels: &[Level::Components],
    subjects: Subject::each_rotary_axis,
    parameters: |scene, subject| parameters_across(scene, subject, SHIFTS),
    shape: Shape::Waves(1),
    form: Form::WavesAcross(SHIFTS),
    explanation: Explanation {
        cause: "the bearing of the axis is not true: races out of round, unequal rolling elements, a clamped housing, or a drive that pulls on one side",
        consequence: "the centre of rotation moves: round features become lobed with one wave more or fewer",
        action: "check the preload and seats of the bearing; two waves point to a race clamped out of round, more to bolts or rolling elements; compensate over a full turn if the control can",
        separate_by: "measure a precision ball on the axis with two probes at right angles (ISO 230-7), at two heights: radial motion stays the same, tilt grows with height",
    },
};
