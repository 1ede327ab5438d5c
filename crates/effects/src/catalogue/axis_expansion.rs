//! The scale of a linear axis grows: the axis goes `α τ q` further.
//!
//! α is `expansion` in ppm over the campaign.

use crate::{Effect, Explanation, Form, Layer, Level, PPM, Parameter, Shape, Subject};

/// Steel over 27 K, aluminium over 13 K: no scale or screw grows or shrinks more while it is measured.
const MOST_PPM: [f64; 2] = [-300.0, 300.0];

pub(super) const EFFECT: Effect = Effect {
    id: "axis_expansion",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::each_linear_axis,
    parameters: |_, _| vec![Parameter::new("expansion", "ppm").plausible(MOST_PPM)],
    shape: Shape::Fixed,
    form: Form::Growth(|of| PPM * of.at.progress),
    explanation: Explanation {
        cause: "the screw or the scale of the axis warms up and grows: steel 11 ppm per K",
        consequence: "the positioning error of the axis is a mixture of different instants",
        action: "warm the axis up before measuring, log the temperature of its scale, compensate thermally",
        separate_by: "measure the axis at the start and at the end of the campaign, with the temperature of its scale",
    },
};
