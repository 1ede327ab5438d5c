//! A component error that repeats with the position of its axis: `s sin(2πq/λ) + c cos(2πq/λ)`.
//!
//! λ is the pitch of a screw, the division of a scale or grating, the spacing of the rolling elements of
//! a guideway, or a simple part of one of these.

use std::f64::consts::TAU;

use nalgebra::Vector6;
use trueaxis_kinematics::{ARCSEC, Component, MICROMETRE, MotionError};

use crate::curve::{curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Shape, Subject,
};

#[derive(Debug)]
pub(super) struct CyclicError;

impl Effect for CyclicError {
    fn id(&self) -> &'static str {
        "cyclic_error"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components, Level::Verification]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let axes = scene.moving.iter();
        axes.flat_map(|&axis| Component::ALL.map(|component| Subject::component(axis, component)))
            .collect()
    }

    fn parameters(&self, _: &Scene, subject: &Subject) -> Vec<Parameter> {
        let angular = subject.component.is_some_and(Component::is_angular);
        let unit = if angular { "arcsec" } else { "um" };
        ["sine", "cosine"]
            .map(|name| Parameter::new(name, unit))
            .into()
    }

    fn shape(&self) -> Shape {
        Shape::Period
    }

    fn form(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &Circumstances<'_>,
    ) -> Displaced {
        curve_form(self, subject, parameter, shape, at)
    }

    fn motion(
        &self,
        subject: &Subject,
        parameter: usize,
        shape: f64,
        at: &AxisPosition<'_>,
    ) -> MotionError {
        let Some(component) = subject.component else {
            return MotionError::default();
        };
        let unit = if component.is_angular() {
            ARCSEC
        } else {
            MICROMETRE
        };
        let value = unit * sine_or_cosine(parameter, TAU * at.position / shape);
        MotionError::from_vector(&Vector6::ith(component.index(), value))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "something that repeats along the axis: the pitch of the screw and its bearing, the division of the scale, the rolling elements of the guideway",
            consequence: "between two measured positions the error is not on the straight line that a compensation table draws: up to the whole amplitude stays",
            action: "compare the period with the pitch of the screw, the period of the scale and the rollers; mend the part (bearing, alignment of the scale's head, its signal), or compensate with a table of at least eight points per period",
            separate_by: "measure one or two periods again with a step of an eighth of the period: a shorter period seen with a coarse step shows as a longer one",
        }
    }
}
