//! A wrong scale of all lengths: `s · l`. Stations and points stretch with it, so no length shows it.

use crate::PPM;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct LengthScale;

impl Effect for LengthScale {
    fn id(&self) -> &'static str {
        "length_scale"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
    }

    fn levels(&self) -> &'static [Level] {
        &[]
    }

    fn subjects(&self, _: &Scene) -> Vec<Subject> {
        vec![Subject::default()]
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("scale", "ppm")]
    }

    fn form(&self, _: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        Displaced::length(PPM * at.distance_mm)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the wavelength is compensated with wrong air data, or the laser's frequency is off",
            consequence: "every positioning error has this error of scale",
            action: "check the weather station and the laser's calibration",
            separate_by: "measure a calibrated length standard, or one line with another interferometer, at the same time",
        }
    }
}
