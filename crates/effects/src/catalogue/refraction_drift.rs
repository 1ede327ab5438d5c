//! The air, so the length scale, drifts over the campaign: `D_l = s · l · τ`.
//!
//! s is `scale_drift` in ppm over the campaign; a positive one makes lengths longer.

use crate::{Effect, Explanation, Form, Layer, Level, PPM, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "refraction_drift",
    layer: Layer::Instrument,
    levels: &[Level::Lengths],
    subjects: Subject::all_alike,
    parameters: |_, _| vec![Parameter::new("scale_drift", "ppm")],
    shape: Shape::Fixed,
    form: Form::Length(|of| PPM * of.at.distance_mm * of.at.progress),
    explanation: Explanation {
        cause: "the refractive index of the air drifts and is not (rightly) compensated: 1 ppm is 1 K, 4 hPa",
        consequence: "the scale of the machine changes from axis to axis with the time of its measurement",
        action: "log air temperature and pressure, check the weather station, calibrate the axes with the scale at one instant",
        separate_by: "record air temperature (1 K is 0.95 ppm) and pressure (1 hPa is 0.27 ppm) with the lengths",
    },
};
