//! The worm of a rotary axis: n waves per turn of the angle about the axis, `s sin nq + c cos nq`.
//!
//! n (`waves`) is the number of revolutions of the worm in one turn of the axis, or a multiple of it; one and
//! two waves per turn belong to the encoder's disc. s and c are `sine` and `cosine` in arcsec, positive about
//! the axis.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "worm_gear",
    layer: Layer::Machine,
    levels: &[Level::Components],
    subjects: Subject::each_rotary_axis,
    parameters: |_, _| Parameter::sine_and_cosine("arcsec"),
    shape: Shape::Waves(3),
    form: Form::WavesAbout(None),
    explanation: Explanation {
        cause: "the worm or pinion of the drive has run-out, or its teeth differ: the error repeats with every revolution of the worm",
        consequence: "between two measured angles the error is not on the straight line that a compensation table draws",
        action: "compare the number of waves with the ratio of the gear; check the worm's run-out and bearing; compensate with at least eight points per wave",
        separate_by: "measure one or two waves with a step of an eighth of a wave: more waves than the step can show appear as fewer",
    },
};
