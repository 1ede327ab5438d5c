//! The tripod creeps: `D_S = v · w`, w the progress within the occupation of the station; a length changes by `-u·v w`.
//!
//! One tripod, or all alike: the tracker warms up, or the floor gives way, in every occupation. v is `creep_x`,
//! `creep_y`, `creep_z` in µm per occupation, in the reference frame.
//!
//! Where coordinates are measured there are no stations: the frame of the instrument moves by these at the origin of the
//! reference frame, and turns by `creep_a`, `creep_b`, `creep_c` in arcsec about the reference axes.

use crate::{
    CREPT, Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject,
};

pub(super) const EFFECT: Effect = Effect {
    id: "station_drift",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::each_station_and_all,
    parameters: |scene, _| Parameter::of_station("creep", scene, CREPT),
    shape: Shape::Fixed,
    form: Form::Station(|of| MICROMETRE * of.at.occupation_progress),
    explanation: Explanation {
        cause: "the tripod or the floor under it gives way, or the tracker moves as it warms up",
        consequence: "points measured late in the occupation are off; squareness and straightness are distorted",
        action: "let the tripod settle, shade it, fix it to the floor, measure this station again",
        separate_by: "read three fixed targets on the bed at the start and the end of the occupation: their readings change if the tripod creeps, and stay if the machine drifts",
    },
};
