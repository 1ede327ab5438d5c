//! `campaign.json` as it stands in the file: degrees, names instead of indices, nothing checked.

use serde::{Deserialize, Serialize};
use trueaxis_files::Format;

use crate::Instrument;

/// The format read and written.
pub(crate) const FORMAT: Format = Format {
    name: "trueaxis-campaign",
    version: 1,
    noun: "a campaign",
};

/// The whole document.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: the campaign")]
pub(crate) struct Document {
    pub(crate) format: String,
    pub(crate) version: u32,
    pub(crate) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) date: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) operator: Option<String>,
    pub(crate) machine: MachineSpec,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) instrument: Option<Instrument>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) targets: Vec<TargetEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) stations: Vec<StationEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) known_lengths: Vec<KnownLengthEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) runs: Vec<RunEntry>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) lengths: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) verification: Vec<VerificationEntry>,
}

/// Nominal geometry of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: the machine")]
pub struct MachineSpec {
    /// Name of the machine.
    pub name: String,
    /// Its branches.
    pub kinematics: KinematicsSpec,
    /// Its axes in the order of the columns of the tables.
    pub axes: Vec<AxisSpec>,
}

/// The two branches, each from the bed outwards.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "an object with the lists `tool` and `workpiece`"
)]
pub struct KinematicsSpec {
    /// Names of the axes from bed to tool; none if it is not given.
    #[serde(default)]
    pub tool: Vec<String>,
    /// Names of the axes from bed to workpiece; none if it is not given.
    #[serde(default)]
    pub workpiece: Vec<String>,
}

/// Nominal geometry of an axis in the reference frame at home.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: an axis")]
pub struct AxisSpec {
    /// Name, as `X`.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKindSpec,
    /// Unit vector of positive motion or right-hand rotation.
    pub direction: [f64; 3],
    /// Lowest and highest position, mm or deg.
    pub travel: [f64; 2],
    /// A point on a rotary axis, mm; a linear axis has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_mm: Option<[f64; 3]>,
    /// Thermal expansion of a linear axis, µm per m and K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expansion_ppm_per_k: Option<f64>,
    /// The column of `lengths.csv` with its temperature; `machine_temp_c` if it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_column: Option<String>,
    /// Standard uncertainty of that temperature as the axis', K.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_sigma_k: Option<f64>,
}

/// `linear` or `rotary`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxisKindSpec {
    /// Positions in mm.
    Linear,
    /// Positions in degrees.
    Rotary,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a target")]
pub(crate) struct TargetEntry {
    pub(crate) name: String,
    pub(crate) position_mm: [f64; 3],
    /// Null is the bed, and must not be taken for a field left out.
    #[serde(deserialize_with = "Option::deserialize")]
    pub(crate) carried_by: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) reflector: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) position_sigma_mm: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a station")]
pub(crate) struct StationEntry {
    pub(crate) name: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) approx_mm: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) dead_path_mm: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) dead_path_sigma_mm: Option<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object: a known length")]
pub(crate) struct KnownLengthEntry {
    pub(crate) targets: [String; 2],
    pub(crate) length_mm: f64,
    pub(crate) sigma_um: f64,
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) length_is_calibrated: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) u_um: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) u_ppm: Option<f64>,
    pub(crate) readings: String,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum VerificationKindEntry {
    Positioning,
    Ballbar,
}
