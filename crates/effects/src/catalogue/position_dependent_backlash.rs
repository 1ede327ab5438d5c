//! Lost motion that changes along the axis, as a worn screw has it: `±b(q)/2` by side of approach as in `backlash`,
//! `b(q) = mean + slope (q - q_mid)` with `q_mid` in the middle of travel.
//!
//! `lost_motion_mean` in µm, `lost_motion_slope` in µm/m; of a rotary axis in arcsec and arcsec/rad.

use trueaxis_kinematics::AxisKind;

use super::backlash::lost_motion;
use crate::form::AtReading;
use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

const MM_PER_M: f64 = 1e3;

pub(super) const EFFECT: Effect = Effect {
    id: "position_dependent_backlash",
    layer: Layer::Machine,
    levels: &[Level::Components, Level::Verification],
    subjects: Subject::each_axis,
    parameters: |scene, subject| {
        vec![
            lost_motion(scene, subject, "lost_motion_mean"),
            Parameter::new(
                "lost_motion_slope",
                scene.unit(subject, "um/m", "arcsec/rad"),
            ),
        ]
    },
    shape: Shape::Fixed,
    form: Form::LostMotion(|of| match of.parameter {
        0 => 1.0,
        _ => from_middle(of),
    }),
    explanation: Explanation {
        cause: "lost motion of the axis that is not the same along it: wear, the fit of screw, worm or rack, or friction that changes",
        consequence: "the two sides of approach differ by a different amount at each position; one value in the backlash compensation is right at one position only",
        action: "look at drive and guideways where it is largest, or give the control a table of backlash over position",
        separate_by: "measure the axis from both sides with a finer step where it is used most: play that follows wear is largest there",
    },
};

/// Lost motion that is largest in the middle of travel, as of a drive that is worn there.
pub const WORN_IN_THE_MIDDLE: Explanation = Explanation {
    cause: "the drive is worn where it is used most: play that is larger in the middle of the measured travel than at its ends",
    consequence: EFFECT.explanation.consequence,
    action: "replace or re-preload the screw or worm, or give the control a table of backlash over position",
    separate_by: EFFECT.explanation.separate_by,
};

/// Lost motion that changes its sign along the axis, as no play does.
pub const LOST_MOTION_OF_BOTH_SIGNS: Explanation = Explanation {
    cause: "the two sides of approach differ by an amount that changes its sign along the axis: friction, wind-up or the way the control stops; play alone has one sign",
    consequence: "the two sides of approach differ by a different amount at each position; one value in the backlash compensation is right at one position only",
    action: "look at guideways, preload and servo settings before the compensation; a table for each direction takes away what repeats",
    separate_by: "measure the axis from both sides at two feeds and with a finer step: what the control makes changes with the feed",
};

/// Distance from the middle of travel, m or rad.
fn from_middle(of: &AtReading<'_>) -> f64 {
    let Some(axis) = of.axis() else {
        return 0.0;
    };
    let [low, high] = axis.travel();
    let from_middle = of.position() - 0.5 * (low + high);
    match axis.kind() {
        AxisKind::Linear => from_middle / MM_PER_M,
        AxisKind::Rotary => from_middle,
    }
}
