//! `campaign.json` as it stands in the file: degrees, names instead of indices, nothing checked.

use serde::{Deserialize, Serialize};

/// The whole document.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: the campaign")]
pub(crate) struct Document {
    pub(crate) format: String,
    pub(crate) version: u32,
    pub(crate) name: String,
    pub(crate) machine: MachineEntry,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) instrument: Option<InstrumentEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) targets: Vec<TargetEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) stations: Vec<StationEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) runs: Vec<RunEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) lengths: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) verification: Vec<VerificationEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: the machine")]
pub(crate) struct MachineEntry {
    pub(crate) name: String,
    pub(crate) kinematics: KinematicsEntry,
    pub(crate) axes: Vec<AxisEntry>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "an object with the lists `tool` and `workpiece`"
)]
pub(crate) struct KinematicsEntry {
    pub(crate) tool: Vec<String>,
    pub(crate) workpiece: Vec<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: an axis")]
pub(crate) struct AxisEntry {
    pub(crate) name: String,
    pub(crate) kind: AxisKindEntry,
    pub(crate) direction: [f64; 3],
    /// mm or degrees.
    pub(crate) travel: [f64; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) position_mm: Option<[f64; 3]>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum AxisKindEntry {
    Linear,
    Rotary,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: the instrument")]
pub(crate) struct InstrumentEntry {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(crate) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) length_sigma_um: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) length_sigma_ppm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) repeatability_um: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a target")]
pub(crate) struct TargetEntry {
    pub(crate) name: String,
    pub(crate) position_mm: [f64; 3],
    pub(crate) carried_by: String,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a station")]
pub(crate) struct StationEntry {
    pub(crate) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) approx_mm: Option<[f64; 3]>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a run")]
pub(crate) struct RunEntry {
    pub(crate) name: String,
    pub(crate) axis: String,
}

/// Both kinds of verification. Which fields belong to which kind is checked afterwards: a tagged
/// enum would lose the line and the path of what is wrong inside it.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a verification")]
pub(crate) struct VerificationEntry {
    pub(crate) name: String,
    pub(crate) kind: VerificationKindEntry,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) axis: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) target_mm: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ball_mm: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ball_carried_by: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) center_mm: Option<[f64; 3]>,
    pub(crate) readings: String,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum VerificationKindEntry {
    Positioning,
    Ballbar,
}
