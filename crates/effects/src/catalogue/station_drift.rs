//! The tripod creeps: `-u·v · w`, w the progress within the turn of the station.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct StationDrift;

impl Effect for StationDrift {
    fn id(&self) -> &'static str {
        "station_drift"
    }

    fn layer(&self) -> Layer {
        Layer::Setup
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        // One tripod, or all alike: the tracker warms up, or the floor gives way, in every turn.
        let one = (0..scene.stations.len()).map(Subject::station);
        one.chain([Subject::default()]).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        Parameter::vector_um("creep")
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
        Displaced::station(Vector3::ith(parameter, MICROMETRE) * at.turn_progress)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the tripod or the floor under it gives way, or the tracker moves as it warms up",
            consequence: "points measured late in the turn are off; squareness and straightness are bent",
            action: "let the tripod settle, shade it, fix it to the floor, measure this station again",
            separate_by: "read three fixed targets on the bed at the start and the end of the turn: they move against a tripod that creeps, not against a machine that drifts",
        }
    }
}
