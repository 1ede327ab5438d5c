//! The zero of the interferometer drifts: `rate_j · w`, w the progress within the turn of station j.

use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct DeadPathDrift;

impl Effect for DeadPathDrift {
    fn id(&self) -> &'static str {
        "dead_path_drift"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        // One station, or each with a rate of its own.
        let one = (0..scene.stations.len()).map(Subject::station);
        one.chain([Subject::default()]).collect()
    }

    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        let stations = scene.stations.iter().enumerate();
        let own = stations.filter(|&(i, _)| subject.has_station(i));
        own.map(|(_, name)| Parameter::new(format!("rate_{name}"), "um"))
            .collect()
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        _: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        let station = subject.station.unwrap_or(parameter);
        let here = f64::from(u8::from(at.station == station));
        Displaced::length(here * at.turn_progress * MICROMETRE)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the zero of the tracker's interferometer drifts while it stands at the station",
            consequence: "lengths of the station grow or shrink with time; errors of axes measured late in the turn are bent",
            action: "let the tracker warm up, measure a fixed target on the bed at the start and the end of every turn, measure this station again",
            separate_by: "read a fixed target on the bed through the whole turn: it sees the drift of the zero alone, and two of them at right angles tell it from the tripod",
        }
    }
}
