//! The graduated disc of a rotary axis is off centre: one wave per turn of the angle about the axis,
//! `s sin q + c cos q`.
//!
//! With the centre of the disc e away from the axis and graduation lines on the radius ρ the amplitude is
//! e/ρ: 1 µm on 50 mm gives 4.1 arcsec. s and c are `sine` and `cosine` in arcsec, positive about the axis.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "encoder_eccentricity",
    layer: Layer::Machine,
    levels: &[Level::Components, Level::Verification],
    subjects: Subject::each_rotary_axis,
    parameters: |_, _| Parameter::sine_and_cosine("arcsec"),
    shape: Shape::Fixed,
    form: Form::WavesAbout(Some(1.0)),
    explanation: Explanation {
        cause: "the disc of the encoder (or the gear that drives it) is not centred on the axis",
        consequence: "the angle of the axis is off by a full wave per turn; opposite positions have opposite errors",
        action: "centre the disc, or read it with two opposite heads, which cancels it; else compensate with a table over a full turn",
        separate_by: "compare with an angle standard (autocollimator and polygon) started at two positions of the polygon: what stays with the axis is the encoder",
    },
};
