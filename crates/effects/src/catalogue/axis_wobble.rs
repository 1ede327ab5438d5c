//! The axis of rotation tilts n times per turn: `s sin nq + c cos nq` of the tilts about the two reference
//! directions across the axis (A and B for C), `sine_a` and so on in arcsec; n is `waves`.
//!
//! Of one wave per turn the average axis and the mounting of the targets take the part that turns with
//! the stage, `(cos q, sin q)` and `(-sin q, cos q)`; what is left turns against it. From two waves
//! per turn on all of it is seen.

use crate::waves::{ANGLES, parameters_across};
use crate::{Effect, Explanation, Form, Layer, Level, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "axis_wobble",
    layer: Layer::Machine,
    levels: &[Level::Components],
    subjects: Subject::each_rotary_axis,
    parameters: |scene, subject| parameters_across(scene, subject, ANGLES),
    shape: Shape::Waves(1),
    form: Form::WavesAcross(ANGLES),
    explanation: Explanation {
        cause: "the bearing of the axis is not true: races out of round or tilted against each other, unequal rolling elements, a clamped housing",
        consequence: "the axis has no fixed direction: points far above the table move in proportion to their height",
        action: "check the preload and seats of the bearing; two waves point to a race clamped out of round, more to bolts or rolling elements; compensate tilt over a full turn if the control can",
        separate_by: "measure two balls or a mandrel at two heights with probes at right angles (ISO 230-7): tilt grows with height, radial motion does not",
    },
};
