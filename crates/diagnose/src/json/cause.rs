//! One cause in `diagnosis.json`.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use trueaxis_effects::{GivenEffect, GivenParameter, GivenSubject, Scene};
use trueaxis_files::{Ordered, round, significant};

use crate::json::disturbance::ID;
use crate::json::fitted::FittedFile;
use crate::json::um;
use crate::{Cause, Change, EstimatedParameter, LostMotionAt, Rival};

#[derive(Serialize, JsonSchema)]
pub(super) struct CauseFile<'a> {
    rank: usize,
    effect: &'static str,
    layer: &'static str,
    level: &'static str,
    data: &'a [String],
    subject: GivenSubject,
    p_value: f64,
    delta_bic: f64,
    explained_rms_um: f64,
    share: Option<f64>,
    heldout_gain: Option<f64>,
    parameters: Vec<GivenParameter>,
    /// Lost motion that changes along an axis, at the positions of a line that were reached from both sides.
    curve: Option<Vec<LostMotionFile>>,
    /// The mean of the curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    mean_lost_motion: Option<GivenParameter>,
    /// Of the linear parameters, rows in their order.
    covariance: Vec<Vec<f64>>,
    cannot_tell_apart_from: Vec<RivalFile>,
    separate_by: &'static str,
    cause: &'static str,
    consequence: &'static str,
    action: &'static str,
    component_change: Ordered<ChangeFile<'a>>,
    /// What there is to say about its sizes in several data.
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    follows: Option<FollowsFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    share_of_curve: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted: Option<FittedFile<'a>>,
}

/// Lost motion at a position, µm of a linear axis, arcsec of a rotary one.
#[derive(Serialize, JsonSchema)]
struct LostMotionFile {
    at: [f64; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    value_um: Option<[f64; 1]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    u_um: Option<[f64; 1]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    value_arcsec: Option<[f64; 1]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    u_arcsec: Option<[f64; 1]>,
}

/// The logged temperature that a cause goes with.
#[derive(Serialize, JsonSchema)]
struct FollowsFile {
    column: String,
    plausible: bool,
    plausible_range: [f64; 2],
    unit: &'static str,
}

/// An effect, or a disturbance with its layer and what it varies with.
#[derive(Serialize, JsonSchema)]
struct RivalFile {
    effect: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    varies_with: Option<&'static [&'static str]>,
    subject: GivenSubject,
    /// Of a disturbance less its 2 ln B, which is on the same scale.
    delta_bic: f64,
    parameters: Vec<GivenParameter>,
}

impl RivalFile {
    fn new(rival: &Rival, scene: &Scene) -> Self {
        match rival {
            Rival::Effect { effect, delta_bic } => {
                let given = effect.to_given(scene);
                Self {
                    effect: effect.effect.id,
                    layer: None,
                    varies_with: None,
                    subject: given.subject,
                    delta_bic: round(*delta_bic, 2),
                    parameters: given.parameters,
                }
            }
            Rival::Disturbance { whose, two_ln_b } => Self {
                effect: ID,
                layer: Some(whose.layer.name()),
                varies_with: Some(whose.varies_with),
                subject: GivenSubject::new(&whose.subject, scene),
                delta_bic: round(-two_ln_b, 2),
                parameters: Vec::new(),
            },
        }
    }
}

/// `{ "max_um": 2.2 }`: the field carries the unit.
struct ChangeFile<'a>(&'a Change);

impl Serialize for ChangeFile<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(1))?;
        let field = format!("max_{}", self.0.unit);
        map.serialize_entry(&field, &round(self.0.largest, 6))?;
        map.end()
    }
}

impl JsonSchema for ChangeFile<'_> {
    fn schema_name() -> Cow<'static, str> {
        "ChangeFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "properties": {
                "max_um": { "type": "number" },
                "max_mm": { "type": "number" },
                "max_arcsec": { "type": "number" },
            },
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": false
        })
    }
}

impl<'a> CauseFile<'a> {
    pub(super) fn new(rank: usize, cause: &'a Cause, scene: &Scene) -> Self {
        let explanation = cause.explanation();
        let rivals = cause.rivals.iter();
        let changes = cause.changes.iter();
        Self {
            rank,
            effect: cause.effect.effect.id,
            layer: cause.layer().name(),
            level: cause.level.name(),
            data: &cause.data,
            subject: cause.effect.to_given(scene).subject,
            p_value: significant(cause.p_value),
            delta_bic: round(cause.delta_bic, 2),
            explained_rms_um: um(cause.explained_rms_um),
            share: cause.share.map(|share| round(share, 4)),
            heldout_gain: cause.heldout_gain.map(|gain| round(gain, 4)),
            parameters: cause.parameters.iter().map(estimated).collect(),
            curve: lost_motion(cause),
            mean_lost_motion: cause.mean_lost_motion.as_ref().map(estimated),
            covariance: covariance(cause),
            cannot_tell_apart_from: rivals.map(|own| RivalFile::new(own, scene)).collect(),
            separate_by: explanation.separate_by,
            cause: explanation.cause,
            consequence: explanation.consequence,
            action: explanation.action,
            component_change: Ordered(changes.map(|c| (c.name.clone(), ChangeFile(c))).collect()),
            note: cause.note(),
            follows: cause.follows(scene).map(|follows| FollowsFile {
                column: follows.column.to_owned(),
                plausible: follows.is_plausible,
                plausible_range: follows.range,
                unit: follows.unit,
            }),
            share_of_curve: cause.share_of_curve.map(|share| round(share, 4)),
            fitted: cause.fitted.as_ref().map(FittedFile::new),
        }
    }
}

/// The curve of a lost motion, if it has one.
fn lost_motion(cause: &Cause) -> Option<Vec<LostMotionFile>> {
    let is_angle = cause.has_angular_curve()?;
    let point = |own: &LostMotionAt| {
        let told = |is_it: bool, value: f64| is_it.then(|| [round(value, 4)]);
        LostMotionFile {
            at: [round(own.at, 3)],
            value_um: told(!is_angle, own.value),
            u_um: told(!is_angle, own.u),
            value_arcsec: told(is_angle, own.value),
            u_arcsec: told(is_angle, own.u),
        }
    };
    Some(cause.curve.iter().map(point).collect())
}

fn estimated(estimated: &EstimatedParameter) -> GivenParameter {
    GivenParameter {
        name: estimated.name.clone(),
        value: estimated.value,
        u: Some(estimated.u).filter(|u| u.is_finite()),
        unit: estimated.unit.to_owned(),
    }
}

/// The effect with names, and its values with their uncertainties.
pub(super) fn given(cause: &Cause, scene: &Scene) -> GivenEffect {
    let mut given = cause.effect.to_given(scene);
    for parameter in &mut given.parameters {
        let estimated = cause.parameters.iter().find(|e| e.name == parameter.name);
        parameter.u = estimated.map(|e| e.u).filter(|u| u.is_finite());
    }
    given
}

/// The rows of its covariance.
pub(super) fn covariance(cause: &Cause) -> Vec<Vec<f64>> {
    let count = cause.effect.parameters.len().max(1);
    let rows = cause.covariance.chunks(count);
    rows.map(<[f64]>::to_vec).collect()
}
