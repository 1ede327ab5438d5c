//! A wrong scale of all lengths: `D_l = s · l`. Stations and points stretch with it, so no length shows it.
//!
//! s is `scale` in ppm; with a positive one lengths are shown too long.

use crate::{Effect, Explanation, Form, Layer, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "length_scale",
    layer: Layer::Instrument,
    levels: &[],
    subjects: Subject::all_alike,
    parameters: |_, _| vec![Parameter::new("scale", "ppm")],
    shape: Shape::Fixed,
    form: Form::Scale(|_| 1.0),
    explanation: Explanation {
        cause: "the wavelength is compensated with wrong air data, or the laser's frequency is off",
        consequence: "every positioning error has this error of scale",
        action: "check the weather station and the laser's calibration",
        separate_by: "measure a calibrated length standard, or one line with another interferometer, at the same time",
    },
};
