//! The beam is interrupted at t0: the zero of the interferometer jumps, `a · [t > t0, this station]`.

use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Shape, Subject,
};

#[derive(Debug)]
pub(super) struct DeadPathJump;

impl Effect for DeadPathJump {
    fn id(&self) -> &'static str {
        "dead_path_jump"
    }

    fn layer(&self) -> Layer {
        Layer::Instrument
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        (0..scene.stations.len()).map(Subject::station).collect()
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        vec![Parameter::new("jump", "um")]
    }

    fn shape(&self) -> Shape {
        Shape::Instant
    }

    fn form(&self, subject: &Subject, _: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        let here = f64::from(u8::from(subject.has_station(at.station)));
        Displaced::length(here * MICROMETRE)
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the beam of this station was interrupted, or the interferometer lost counts: its zero jumped",
            consequence: "all lengths of the station after it are off by the same amount",
            action: "give the station a new zero from this instant (calibrate does so on its own), or measure the rest of the turn again",
            separate_by: "read a fixed target on the bed before and after: a jump of the zero shows there, too, whatever its direction",
        }
    }
}
