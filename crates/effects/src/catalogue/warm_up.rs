//! The machine warms up: `D_p = a · (1 - exp(-t/T))`, t since the first reading.
//!
//! a is `growth_x`, `growth_y`, `growth_z` in µm, in the reference frame; T is `time_constant` in s.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

/// A column of 2 m of steel grows by 0.5 mm over 23 K.
const MOST_UM: [f64; 2] = [-500.0, 500.0];

pub(super) const EFFECT: Effect = Effect {
    id: "warm_up",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::all_alike,
    parameters: |_, _| {
        let growth = Parameter::vector("growth", "um").into_iter();
        growth.map(|g| g.plausible(MOST_UM)).collect()
    },
    shape: Shape::TimeConstant,
    form: Form::Target(|of| {
        let part = 1.0 - (-of.at.elapsed_s / of.shape).exp();
        MICROMETRE * part
    }),
    explanation: Explanation {
        cause: "the machine was cold: spindle, drives or coolant warm its structure up",
        consequence: "the first and the last readings are of different machines",
        action: "run the machine for three time constants before measuring, or leave out the first cycles",
        separate_by: "wait for three time constants and measure the first run again: it must not change any more",
    },
};
