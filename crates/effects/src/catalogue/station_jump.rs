//! The tripod is bumped at t0: `-u·d · [t > t0, this station]`.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Shape, Subject,
};

#[derive(Debug)]
pub(super) struct StationJump;

impl Effect for StationJump {
    fn id(&self) -> &'static str {
        "station_jump"
    }

    fn layer(&self) -> Layer {
        Layer::Setup
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        (0..scene.stations.len()).map(Subject::station).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        Parameter::vector_um("jump")
    }

    fn shape(&self) -> Shape {
        Shape::Instant
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        if !subject.has_station(at.station) {
            return Displaced::default();
        }
        Displaced::station(Vector3::ith(parameter, MICROMETRE))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "somebody or something bumped the tripod",
            consequence: "the rest of the turn was measured from another place",
            action: "measure this station again from the start of the turn, or treat the rest as a station of its own",
            separate_by: "read three fixed targets on the bed before and after: they move against a tripod that was bumped, not against a machine that shifted",
        }
    }
}
