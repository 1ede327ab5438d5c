//! The positioning error of a linear axis grows in proportion to position: `δ = s q d`, d the direction of the axis.
//!
//! s is `scale` in ppm; with a positive one the axis goes too far.

use crate::{Effect, Explanation, Form, Layer, Level, PPM, Parameter, Shape, Subject};

/// A millimetre in a metre: a wrong pitch or factor, which nobody would call an error of the scale.
const MOST_PPM: [f64; 2] = [-1000.0, 1000.0];

pub(super) const EFFECT: Effect = Effect {
    id: "scale_error",
    layer: Layer::Machine,
    levels: &[Level::Components, Level::Verification],
    subjects: Subject::each_linear_axis,
    parameters: |_, _| vec![Parameter::new("scale", "ppm").plausible(MOST_PPM)],
    shape: Shape::Fixed,
    form: Form::Positioning(|of| PPM * of.at.position),
    explanation: Explanation {
        cause: "the length standard of the axis is off: pitch of the screw, temperature or mounting of the scale, its tilt against the way, a wrong compensation factor; or all lengths of the instrument are off in scale",
        consequence: "every length that the axis makes is wrong in proportion",
        action: "check the temperature of the scale and the coefficient of expansion that was assumed, then enter the factor in the control",
        separate_by: "all axes off by the same amount point to the instrument's length scale: measure one line with another interferometer or a calibrated step gauge",
    },
};
