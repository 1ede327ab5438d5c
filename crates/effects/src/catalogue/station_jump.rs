//! The tripod is bumped at t0: `D_S = d · [t > t0, this station]`; a length changes by `-u·d`.
//!
//! d is `jump_x`, `jump_y`, `jump_z` in µm, in the reference frame.

use trueaxis_kinematics::MICROMETRE;

use crate::{Effect, Explanation, Form, Layer, Level, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "station_jump",
    layer: Layer::Setup,
    levels: &[Level::Lengths],
    subjects: Subject::each_station,
    parameters: |_, _| Parameter::vector("jump", "um"),
    shape: Shape::Instant,
    form: Form::Station(|_| MICROMETRE),
    explanation: Explanation {
        cause: "somebody or something bumped the tripod",
        consequence: "the rest of the turn was measured from another place",
        action: "measure this station again from the start of the turn, or treat the rest as a station of its own",
        separate_by: "read three fixed targets on the bed before and after: they move against a tripod that was bumped, not against a machine that shifted",
    },
};
