//! The tool creeps against the bed in proportion to time: `D_p = v · τ`.
//!
//! v is `drift_x`, `drift_y`, `drift_z` in µm over the campaign, in the reference frame.

use trueaxis_kinematics::MICROMETRE;

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "machine_drift",
    layer: Layer::Machine,
    levels: &[Level::Lengths, Level::Points, Level::Verification],
    subjects: Subject::all_alike,
    parameters: |_, _| Parameter::vector("drift", "um"),
    shape: Shape::Fixed,
    form: Form::Target(|of| MICROMETRE * of.at.progress),
    explanation: Explanation {
        cause: "the machine drifts: its structure or its foundation deforms slowly as a whole",
        consequence: "each station sees a different machine; squareness and straightness are distorted",
        action: "warm the machine up, keep doors and cooling as in use, shorten the campaign",
        separate_by: "read three fixed targets on the bed at the start and the end of every occupation: they stand still against the tracker when the machine drifts, and move with a tripod that creeps",
    },
};
