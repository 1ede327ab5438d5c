//! The axis of rotation tilts n times per turn: `s sin nq + c cos nq` of the tilts about the two reference
//! directions across the axis (A and B for C).
//!
//! Of one wave per turn the average axis and the mounting of the targets take the part that turns with
//! the stage, `(cos q, sin q)` and `(-sin q, cos q)`; what is left turns against it. From two waves
//! per turn on all of it is seen.

use nalgebra::Vector6;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MotionError};

use crate::curve::{across, curve_form, sine_or_cosine};
use crate::{
    AxisPosition, Circumstances, Displaced, Effect, Explanation, Layer, Level, Parameter, Scene,
    Shape, Subject,
};

#[derive(Debug)]
pub(super) struct AxisWobble;

impl Effect for AxisWobble {
    fn id(&self) -> &'static str {
        "axis_wobble"
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
            let letter = ['a', 'b', 'c'][i];
            ["sine", "cosine"].map(|name| Parameter::new(format!("{name}_{letter}"), "arcsec"))
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
        let component = Component::ALL[3 + across[parameter / 2]];
        let value = ARCSEC * sine_or_cosine(parameter % 2, shape * at.position);
        MotionError::from_vector(&Vector6::ith(component.index(), value))
    }

    fn explanation(&self) -> Explanation {
        Explanation {
            cause: "the bearing of the axis is not true: races out of round or tilted against each other, unequal rolling elements, a clamped housing",
            consequence: "the axis has no fixed direction: points far above the table move in proportion to their height",
            action: "check the preload and seats of the bearing; two waves point to a race clamped out of round, more to bolts or rolling elements; compensate tilt over a full turn if the control can",
            separate_by: "measure two balls or a mandrel at two heights with probes at right angles (ISO 230-7): tilt grows with height, radial motion does not",
        }
    }
}
