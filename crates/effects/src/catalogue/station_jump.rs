//! The tripod is bumped at t0: `D_S = d · [t > t0, this station]`; a length changes by `-u·d`.
//!
//! d is `jump_x`, `jump_y`, `jump_z` in µm, in the reference frame.
//!
//! Where coordinates are measured there are no stations: the frame of the instrument moves by these at the origin of the
//! reference frame, and turns by `jump_a`, `jump_b`, `jump_c` in arcsec about the reference axes.

use crate::{
    BUMPED, Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject,
};

pub(super) const EFFECT: Effect = Effect {
    id: "station_jump",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::each_station_or_frame,
    parameters: |scene, _| Parameter::of_station("jump", scene, BUMPED),
    shape: Shape::Instant,
    form: Form::Station(|_| MICROMETRE),
    explanation: Explanation {
        cause: "somebody or something bumped the tripod",
        consequence: "the rest of the occupation was measured from another place",
        action: "measure this station again from the start of the occupation, or treat the rest as a station of its own",
        separate_by: "read three fixed targets on the bed before and after: their readings jump if the tripod was bumped, and stay if the machine shifted",
    },
};
