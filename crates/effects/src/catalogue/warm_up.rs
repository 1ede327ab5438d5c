//! The machine warms up: `u·a · (1 - exp(-t/T))`, t since the
//! first reading.

use nalgebra::Vector3;
use trueaxis_kinematics::MICROMETRE;

use crate::{
    Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene, Shape, Subject,
};

#[derive(Debug)]
pub(super) struct WarmUp;

impl Effect for WarmUp {
    fn id(&self) -> &'static str {
        "warm_up"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Lengths, Level::Verification]
    }

    fn subjects(&self, _: &Scene) -> Vec<Subject> {
        vec![Subject::default()]
    }

    fn parameters(&self, _: &Scene, _: &Subject) -> Vec<Parameter> {
        Parameter::vector_um("growth")
    }

    fn shape(&self) -> Shape {
        Shape::TimeConstant
    }

    fn form(&self, _: &Subject, parameter: usize, shape: f64, at: &Circumstances<'_>) -> Displaced {
        let part = 1.0 - (-at.elapsed_s / shape).exp();
        Displaced::point(Vector3::ith(parameter, MICROMETRE * part))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the machine was cold: spindle, drives or coolant warm its structure up",
            consequence: "the first stations and runs see another machine than the last ones",
            action: "run the machine for three time constants before measuring, or take the first cycles out",
            separate_by: "wait for three time constants and measure the first run again: it must not change any more",
        }
    }
}
