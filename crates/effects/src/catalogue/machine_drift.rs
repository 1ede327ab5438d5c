//! The tool creeps against the bed in proportion to time: `u·v · τ`.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Subject,
};

#[derive(Debug)]
pub(super) struct MachineDrift;

impl Effect for MachineDrift {
    fn id(&self) -> &'static str {
        "machine_drift"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths]
    }

    fn subjects(&self, _: &Scene) -> Vec<Subject> {
        vec![Subject::default()]
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        Parameter::vector_um("drift")
    }

    fn form(&self, _: &Subject, parameter: usize, _: f64, at: &Circumstances<'_>) -> Displaced {
        Displaced::point(Vector3::ith(parameter, MICROMETRE * at.progress))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the machine drifts: its structure or its foundation deforms slowly as a whole",
            consequence: "stations measured one after another see another machine; squareness and straightness are bent",
            action: "warm the machine up, keep doors and cooling as in use, shorten the campaign",
            separate_by: "read three fixed targets on the bed at the start and the end of every turn: they stand still against the tracker when the machine drifts, and move with a tripod that creeps",
        }
    }
}
