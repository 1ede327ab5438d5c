//! The axis of rotation moves sideways n times per turn: `s sin nq + c cos nq` along the two reference
//! directions across the axis (x and y for C).
//!
//! Of one wave per turn the average axis and the mounting of the targets take the part that turns with
//! the stage, `(cos q, sin q)` and `(-sin q, cos q)`; what is left turns against it. From two waves
//! per turn on all of it is seen.

use nalgebra::Vector6;
use trueaxis_kinematics::{AxisKind, Component, MICROMETRE, MotionError};

use crate::curve::{across, curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Shape, Subject,
};

#[derive(Debug)]
pub(super) struct AxisRunout;

impl Effect for AxisRunout {
    fn id(&self) -> &'static str {
        "axis_runout"
    }

    fn layer(&self) -> Layer {
        Layer::Machine
    }

    fn levels(&self) -> &'static [Level] {
        &[Level::Components]
    }

    fn subjects(&self, scene: &Scene) -> Vec<Subject> {
        let axes = scene.moving_axes(AxisKind::Rotary);
        axes.map(Subject::axis).collect()
    }

    fn parameters(&self, scene: &Scene, subject: &Subject) -> Vec<Parameter> {
        let across = subject
            .axis
            .map_or([0, 1], |axis| across(&scene.machine.axes()[axis]));
        let of_direction = across.map(|i| {
            let letter = ['x', 'y', 'z'][i];
            ["sine", "cosine"].map(|name| Parameter::new(format!("{name}_{letter}"), "um"))
        });
        of_direction.into_iter().flatten().collect()
    }

    fn shape(&self) -> Shape {
        Shape::Waves
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
        _: &Subject,
        parameter: usize,
        shape: f64,
        at: &AxisPosition<'_>,
    ) -> MotionError {
        let across = across(at.axis);
        let component = Component::ALL[across[parameter / 2]];
        let value = MICROMETRE * sine_or_cosine(parameter % 2, shape * at.position);
        MotionError::from_vector(&Vector6::ith(component.index(), value))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the bearing of the axis is not true: races out of round, unequal rolling elements, a clamped housing, or a drive that pulls on one side",
            consequence: "the centre of rotation moves: round features become lobed with one wave more or fewer",
            action: "check the preload and seats of the bearing; two waves point to a race clamped out of round, more to bolts or rolling elements; compensate over a full turn if the control can",
            separate_by: "measure a precision ball on the axis with two probes at right angles (ISO 230-7), at two heights: radial motion stays the same, tilt grows with height",
        }
    }
}
