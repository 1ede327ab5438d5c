//! The tripod settles after it was set up: `D_S = v · exp(-t/T)`, t since the first reading of the occupation of
//! the station; a length changes by `-u·v exp(-t/T)`.
//!
//! One tripod, or all alike with one time constant: the tracker warms up, or the feet sink in, at the
//! start of every occupation. v is `settling_x`, `settling_y`, `settling_z` in µm, how far from its final position the
//! station stands at first, in the reference frame; T is `time_constant` in s.
//!
//! Where coordinates are measured there are no stations: the frame of the instrument moves by these at the origin of the
//! reference frame, and turns by `settling_a`, `settling_b`, `settling_c` in arcsec about the reference axes.

use crate::{
    CREPT, Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject,
};

pub(super) const EFFECT: Effect = Effect {
    id: "station_settling",
    layer: Layer::Setup,
    levels: &[Level::Lengths, Level::Points],
    subjects: Subject::each_station_and_all,
    parameters: |scene, _| Parameter::of_station("settling", scene, CREPT),
    shape: Shape::SettlingTime,
    form: Form::Station(|of| MICROMETRE * (-of.at.occupation_elapsed_s / of.shape).exp()),
    explanation: Explanation {
        cause: "the tripod had just been set up: its feet sink in, its joints relax, or the tracker warms up in its new place",
        consequence: "the first runs of the occupation were measured from a different place from the later ones",
        action: "wait for three time constants after setting up, then read the first run of the occupation again; fix the tripod to the floor",
        separate_by: "read three fixed targets on the bed from the start of the occupation on: their readings change if the tripod settles, and stay if the machine warms up",
    },
};
