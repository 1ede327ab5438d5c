//! A component error that repeats with the position of its axis: `s sin(2πq/λ) + c cos(2πq/λ)`.
//!
//! λ is the pitch of a screw, the division of a scale or grating, the spacing of the rolling elements of
//! a guideway, or a simple part of one of these. s and c are `sine` and `cosine` in µm, of an angular
//! component in arcsec; λ is `period` in mm, of a rotary axis in rad (in files degrees).

use std::f64::consts::TAU;

use trueaxis_kinematics::{Component, MotionError};

use crate::waves::{unit, wave_of};
use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "cyclic_error",
    layer: Layer::Machine,
    levels: &[Level::Components, Level::Verification],
    subjects: |scene| {
        let axes = scene.moving.iter();
        axes.flat_map(|&axis| Component::ALL.map(|c| Subject::component(axis, c)))
            .collect()
    },
    parameters: |_, subject| {
        Parameter::sine_and_cosine(subject.component.map_or("um", |c| unit(c).0))
    },
    shape: Shape::Period,
    form: Form::Component(|of| match of.subject.component {
        Some(component) => wave_of(component, of, TAU * of.at.position / of.shape),
        None => MotionError::default(),
    }),
    explanation: Explanation {
        cause: "something that repeats along the axis: the pitch of the screw and its bearing, the division of the scale, the rolling elements of the guideway",
        consequence: "between two measured positions the error is not on the straight line that a compensation table draws: up to the whole amplitude stays",
        action: "compare the period with the pitch of the screw, the period of the scale and the rollers; repair the part (bearing, alignment of the scale's head, its signal), or compensate with a table of at least eight points per period",
        separate_by: "measure one or two periods again with a step of an eighth of the period: a shorter period seen with a coarse step shows as a longer one",
    },
};
