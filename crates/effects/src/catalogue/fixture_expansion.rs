//! The triangle of targets grows: `D_p = α τ (p - centroid)`.
//!
//! α is `expansion` in ppm over the campaign.

use nalgebra::Vector3;

use crate::{Effect, Explanation, Form, Layer, Level, PPM, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "fixture_expansion",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::all_alike,
    parameters: |_, _| vec![Parameter::new("expansion", "ppm")],
    shape: Shape::Fixed,
    form: Form::Displacement(|of| match of.at.carrier {
        Some(_) => (of.at.point_mm - of.at.centroid_mm) * (PPM * of.at.progress),
        // Targets on the bed have no fixture.
        None => Vector3::zeros(),
    }),
    explanation: Explanation {
        cause: "the fixture that carries the targets warms up: steel grows 11 ppm, aluminium 23 ppm per K",
        consequence: "angular errors of axes measured late are scaled and mixed with displacements",
        action: "let the fixture come to temperature, use invar or carbon fibre, log its temperature",
        separate_by: "log the fixture's temperature, measure the distances between the targets at the start and the end",
    },
};
