//! The tool creeps against the bed in proportion to time: `D_p = v · τ`.
//!
//! v is `drift_x`, `drift_y`, `drift_z` in µm over the campaign, in the reference frame.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

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
        consequence: "what is measured at the start and at the end sees different machines; squareness and straightness are distorted",
        action: "warm the machine up, keep doors and cooling as in use, shorten the campaign",
        separate_by: "read fixed points on the bed (three targets, if by a tracker) at the start and the end of every set-up: they stand still when the machine drifts, and move with an instrument or a tripod that creeps",
    },
};
