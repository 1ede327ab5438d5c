//! The refractive index of air is wrong at one station: `D_l = s · l`, this station.
//!
//! s is `scale` in ppm; a positive one makes lengths longer. What all stations have in common is
//! `length_scale`, which no length shows.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "station_scale",
    layer: Layer::Instrument,
    levels: &[Level::Lengths],
    subjects: Subject::each_station,
    parameters: |_, _| vec![Parameter::new("scale", "ppm")],
    shape: Shape::Fixed,
    form: Form::Scale(|_| 1.0),
    explanation: Explanation {
        cause: "the refractive index of the air was wrong at this station: another weather station or sensor, old values, a draught or the sun between tracker and machine; 1 ppm is 1 K, 4 hPa; or the machine had another temperature while it was measured from there, 11 ppm per K",
        consequence: "the station shows all distances too long or too short: squareness and straightness are distorted towards it",
        action: "check what temperature, pressure and humidity the tracker used there, and measure this station again",
        separate_by: "log the temperature of the machine, and measure this station again with the weather station beside the beam, or a calibrated bar between two nests from every station",
    },
};
