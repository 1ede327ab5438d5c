//! The air, so the length scale, drifts over the campaign: `D_l = s · l · τ`, or with its logged temperature:
//! `D_l = s · l · (ϑ - ϑ0)`.
//!
//! s is `scale_drift` in ppm over the campaign, or `scale_per_k` in ppm/K; a positive one makes lengths longer.
//! An instrument that does not compensate shows them shorter by 0.95 ppm for each K that the air is warmer.

use crate::{Effect, Explanation, Form, Layer, Level, Medium, Parameter, Scene, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "refraction_drift",
    layer: Layer::Instrument,
    levels: &[Level::Lengths],
    subjects,
    parameters: |_, subject| match subject.column {
        Some(_) => vec![Parameter::new("scale_per_k", "ppm/K").plausible(PPM_PER_K)],
        None => vec![Parameter::new("scale_drift", "ppm")],
    },
    shape: Shape::Fixed,
    form: Form::Scale(|of| match of.subject.column {
        Some(_) => of.warmer_k(),
        None => of.at.progress,
    }),
    explanation: Explanation {
        cause: "the refractive index of the air drifts and is not, or not correctly, compensated: 1 ppm is 1 K, 4 hPa",
        consequence: "the scale of the machine changes from axis to axis with the time of its measurement",
        action: "log air temperature and pressure, check the weather station, calibrate the axes with the scale at one instant",
        separate_by: "record air temperature (1 K is 0.95 ppm), pressure (1 hPa is 0.27 ppm) and the temperature of the machine (1 K is 11 ppm) with the lengths",
    },
};

/// What the refractive index of air does, with some distance between the beam and where it is logged.
const PPM_PER_K: [f64; 2] = [-1.2, 1.2];

/// Time, and each logged temperature of air that is not compensated.
fn subjects(scene: &Scene) -> Vec<Subject> {
    let columns = scene.columns_of(Medium::Air);
    let with_air = columns.map(|column| Subject::default().with_column(column));
    [Subject::default()].into_iter().chain(with_air).collect()
}
