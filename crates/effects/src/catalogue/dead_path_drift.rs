//! The zero of the interferometer drifts: `D_l = rate_j · w`, w the progress within the occupation of station j.
//!
//! Of one station, or of each with a rate of its own. `rate_S1` and so on in µm per occupation; a positive one makes lengths longer.

use crate::{Effect, Explanation, Form, Layer, Level, MICROMETRE, Parameter, Shape, Subject};

pub(super) const EFFECT: Effect = Effect {
    id: "dead_path_drift",
    layer: Layer::Instrument,
    levels: &[Level::Lengths],
    subjects: Subject::each_station_and_all,
    parameters: |scene, subject| {
        let stations = scene.stations.iter().enumerate();
        let own = stations.filter(|&(i, _)| subject.has_station(i));
        own.map(|(_, name)| Parameter::new(format!("rate_{name}"), "um"))
            .collect()
    },
    shape: Shape::Fixed,
    form: Form::Length(|of| {
        let station = of.subject.station.unwrap_or(of.parameter);
        let here = f64::from(u8::from(of.at.station == station));
        here * of.at.occupation_progress * MICROMETRE
    }),
    explanation: Explanation {
        cause: "the zero of the tracker's interferometer drifts while it stands at the station",
        consequence: "lengths of the station grow or shrink with time; errors of axes measured late in the occupation are distorted",
        action: "let the tracker warm up, measure a fixed target on the bed at the start and the end of every occupation, measure this station again",
        separate_by: "read a fixed target on the bed through the whole occupation: it sees the drift of the zero alone, and two of them at right angles tell it from the tripod",
    },
};
