//! The worm of a rotary axis: n waves per turn of the angle about the axis, `s sin nq + c cos nq`.
//!
//! n (`waves`) is the number of revolutions of the worm in one turn of the axis, or a multiple of it; one and
//! two waves per turn belong to the encoder's disc. Few waves may be harmonics of an encoder or resolver, too. s and c are
//! `sine` and `cosine` in arcsec, positive about the axis.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "worm_gear",
    layer: Layer::Machine,
    levels: &[Level::Components],
    subjects: Subject::each_rotary_axis,
    parameters: |_, _| Parameter::sine_and_cosine("arcsec"),
    shape: Shape::Waves(3),
    form: Form::WavesAbout(None),
    explanation: Explanation {
        cause: "the worm or pinion of the drive has run-out, or its teeth differ: the error repeats with every revolution of the worm",
        consequence: "between two measured angles the error is not on the straight line that a compensation table draws",
        action: "compare the number of waves with the ratio of the gear; check the worm's run-out and bearing; compensate with at least eight points per wave",
        separate_by: "measure one or two waves with a step of an eighth of a wave: more waves than the step can show appear as fewer",
    },
};

/// Most waves per turn that are as likely an encoder's or a resolver's: gears of so low a ratio are rare on a table, and
/// resolvers have up to eight pairs of poles.
pub(crate) const MOST_OF_FEW: f64 = 16.0;

/// Few waves per turn.
pub(crate) const FEW_WAVES: Explanation = Explanation {
    cause: "waves as few as these are harmonics of an encoder or a resolver, or the run-out of a worm or pinion of a low ratio",
    action: "compare the number of waves with the pole pairs of the resolver and twice these, with the heads of the encoder and with the ratio of the gear; compensate with at least eight points per wave",
    consequence: EFFECT.explanation.consequence,
    separate_by: "read the axis with another encoder, or at another place of the scale's disc: what the encoder makes stays with it",
};
