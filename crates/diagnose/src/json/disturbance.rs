//! One disturbance in `diagnosis.json`.

use schemars::JsonSchema;
use serde::Serialize;
use trueaxis_effects::{GivenSubject, Scene};
use trueaxis_files::{round, significant};

use crate::json::um;
use crate::{CurvePoint, Disturbance, Wandering};

#[derive(Serialize, JsonSchema)]
pub(super) struct DisturbanceFile<'a> {
    effect: &'static str,
    layer: &'static str,
    level: &'static str,
    data: [&'a str; 1],
    varies_with: &'static [&'static str],
    subject: GivenSubject,
    p_value: f64,
    rms_um: f64,
    share: f64,
    correlation_length: CorrelationLengthFile,
    #[serde(skip_serializing_if = "Option::is_none")]
    period: Option<f64>,
    heldout_gain: Option<f64>,
    curve: Vec<CurvePointFile>,
    cannot_tell_apart_from: Vec<AlikeFile>,
}

#[derive(Serialize, JsonSchema)]
struct CorrelationLengthFile {
    value: f64,
    unit: &'static str,
}

#[derive(Serialize, JsonSchema)]
struct CurvePointFile {
    #[schemars(length(min = 1, max = 2))]
    at: Vec<f64>,
    value_um: Vec<f64>,
    u_um: Vec<f64>,
}

#[derive(Serialize, JsonSchema)]
struct AlikeFile {
    effect: &'static str,
    layer: &'static str,
    varies_with: &'static [&'static str],
    subject: GivenSubject,
}

/// The effect's id.
pub(super) const ID: &str = "disturbance";

impl<'a> DisturbanceFile<'a> {
    pub(super) fn new(own: &'a Disturbance, scene: &Scene) -> Self {
        let rival = |rival: &Wandering| AlikeFile {
            effect: ID,
            layer: rival.layer.name(),
            varies_with: rival.varies_with,
            subject: GivenSubject::new(&rival.subject, scene),
        };
        Self {
            effect: ID,
            layer: own.whose.layer.name(),
            level: own.level.name(),
            data: [&own.data],
            varies_with: own.whose.varies_with,
            subject: GivenSubject::new(&own.whose.subject, scene),
            p_value: significant(own.p_value),
            rms_um: um(own.rms_um),
            share: round(own.share, 4),
            correlation_length: CorrelationLengthFile {
                value: round(own.correlation_length.value, 3),
                unit: own.correlation_length.unit,
            },
            period: own.period.map(|period| round(period, 3)),
            heldout_gain: own.heldout_gain.map(|gain| round(gain, 4)),
            curve: own.curve.iter().map(point).collect(),
            cannot_tell_apart_from: own.rivals.iter().map(rival).collect(),
        }
    }
}

fn point(point: &CurvePoint) -> CurvePointFile {
    let rounded = |values: &[f64]| values.iter().map(|v| round(*v, 4)).collect();
    let at = [point.at].into_iter().chain(point.position);
    CurvePointFile {
        at: at.map(|x| round(x, 3)).collect(),
        value_um: rounded(&point.value_um),
        u_um: rounded(&point.u_um),
    }
}
