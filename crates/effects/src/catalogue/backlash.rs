//! Lost motion on reversal: after arrival in the positive direction the axis stands at `-b/2`, in the
//! negative direction at `+b/2`: short in both.
//!
//! b is `lost_motion` in µm, of a rotary axis in arcsec.

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Scene, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "backlash",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::each_axis,
    parameters: |scene, subject| vec![lost_motion(scene, subject, "lost_motion")],
    shape: Shape::Fixed,
    form: Form::LostMotion(|_| 1.0),
    explanation: Explanation {
        cause: "lost motion of the axis: play or wind-up between motor and stage",
        consequence: "the two sides of approach differ; their mean is right for neither",
        action: "adjust the drive or the backlash compensation of the control; calibrate --by-direction keeps the sides apart",
        separate_by: "measure the axis from both sides at two feeds: lost motion stays, a time offset of the readings grows with the feed",
    },
};

/// More than a millimetre, or five degrees, is no play of a drive that is in use.
const MOST_UM: [f64; 2] = [-1e3, 1e3];
const MOST_ARCSEC: [f64; 2] = [-1.8e4, 1.8e4];

/// Lost motion as a parameter of this name.
pub(super) fn lost_motion(scene: &Scene, subject: &Subject, name: &'static str) -> Parameter {
    let unit = scene.unit(subject, "um", "arcsec");
    let most = if unit == "um" { MOST_UM } else { MOST_ARCSEC };
    Parameter::new(name, unit).plausible(most)
}

/// Lost motion below zero: the axis goes further than it should after it has turned round.
pub(crate) const OVER_COMPENSATED: Explanation = Explanation {
    cause: "the axis goes too far after a reversal: the backlash compensation of the control is too large, the control stops at the far edge of its window, or forward and backward are exchanged in the file",
    consequence: "the two sides of approach differ; their mean is right for neither",
    action: "of readings, check first that they are measured less commanded, not the other way, and that direction is the side of approach; then lower the backlash compensation by this amount and measure again; check the in-position window of the control; if sign and sides are right, no part is worn",
    separate_by: "measure both sides with the backlash compensation switched off: what a compensation makes goes away, what the control's window makes stays",
};
