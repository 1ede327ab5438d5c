//! The triangle of targets grows: `α τ · u·(p - centroid)`.

use crate::PPM;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct FixtureExpansion;

impl Effect for FixtureExpansion {
    fn id(&self) -> &'static str {
        "fixture_expansion"
    }

    fn layer(&self) -> Layer {
        Layer::Setup
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, _: &Scene) -> Vec<Subject> {
        vec![Subject::default()]
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("expansion", "ppm")]
    }

    fn form(&self, _: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        Displaced::point((at.point_mm - at.centroid_mm) * (PPM * at.progress))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the fixture that carries the targets warms up: steel grows 11 ppm, aluminium 23 ppm per K",
            consequence: "angular errors of axes measured late are scaled and mixed with displacements",
            action: "let the fixture come to temperature, use invar or carbon fibre, log its temperature",
            separate_by: "log the fixture's temperature, measure the distances between the targets at the start and the end",
        }
    }
}
