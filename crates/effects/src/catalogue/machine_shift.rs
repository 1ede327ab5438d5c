//! A sudden shift of the tool against the bed at t0: `u·d · [t > t0]`.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Shape, Subject,
};

#[derive(Debug)]
pub(super) struct MachineShift;

impl Effect for MachineShift {
    fn id(&self) -> &'static str {
        "machine_shift"
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
        Parameter::vector_um("shift")
    }

    fn shape(&self) -> Shape {
        Shape::Instant
    }

    fn form(&self, _: &Subject, parameter: usize, _: f64, _: &Circumstances<'_>) -> Displaced {
        Displaced::point(Vector3::ith(parameter, MICROMETRE))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the machine shifted: referencing, a collision, an axis that was switched off, a clamp that let go",
            consequence: "points before and after it do not belong to one machine",
            action: "find what happened at this instant, reference the machine again, measure again",
            separate_by: "read three fixed targets on the bed before and after: they stand still when the machine shifted, and move against a tripod that was bumped",
        }
    }
}
