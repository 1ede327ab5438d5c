//! The graduated disc of a rotary axis is not round or not flat: two waves per turn of the angle about
//! the axis, `s sin 2q + c cos 2q`.
//!
//! s and c are `sine` and `cosine` in arcsec, positive about the axis.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "encoder_ellipticity",
    layer: Layer::Machine,
    levels: &[Level::Components, Level::Verification],
    subjects: Subject::each_rotary_axis,
    parameters: |_, _| Parameter::sine_and_cosine("arcsec"),
    shape: Shape::Fixed,
    form: Form::WavesAbout(Some(2.0)),
    explanation: Explanation {
        cause: "the disc of the encoder is clamped out of round or tilted, or two opposite heads do not sit opposite",
        consequence: "the angle of the axis is off by two waves per turn; two opposite heads do not cancel it",
        action: "loosen and clamp the disc again, check its axial run-out; else compensate with a table over a full turn",
        separate_by: "compare with an angle standard (autocollimator and polygon) before and after clamping the disc again",
    },
};
