//! A constant offset of all lengths of a station. The dead path takes it up, so no length shows it.

use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct DeadPathOffset;

impl Effect for DeadPathOffset {
    fn id(&self) -> &'static str {
        "dead_path_offset"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
    }

    fn levels(&self) -> &'static [Level] {
        &[]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        (0..scene.stations.len()).map(Subject::station).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("offset", "um")]
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        let here = f64::from(u8::from(subject.has_station(at.station)));
        Displaced::length(here * MICROMETRE)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the interferometer's zero is off by a constant",
            consequence: "none: the dead path of the station takes it up",
            action: "nothing",
            separate_by: "compare the dead path with an absolute distance",
        }
    }
}
