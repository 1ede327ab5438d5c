//! The air, so the length scale, drifts over the campaign: `s · l · τ`.

use crate::PPM;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct RefractionDrift;

impl Effect for RefractionDrift {
    fn id(&self) -> &'static str {
        "refraction_drift"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, _: &Scene) -> Vec<Subject> {
        vec![Subject::default()]
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("scale_drift", "ppm")]
    }

    fn form(&self, _: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        Displaced::length(PPM * at.distance_mm * at.progress)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the refractive index of the air drifts and is not (rightly) compensated: 1 ppm is 1 K, 4 hPa",
            consequence: "the scale of the machine changes from axis to axis with the time of its measurement",
            action: "log air temperature and pressure, check the weather station, calibrate the axes with the scale at one instant",
            separate_by: "record air temperature (1 K is 0.95 ppm) and pressure (1 hPa is 0.27 ppm) with the lengths",
        }
    }
}
