//! `campaign.json` as it stands in the file: degrees, names instead of indices, nothing checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_files::Format;

use crate::Instrument;

/// The format of `campaign.json`.
pub const FORMAT: Format = Format {
    name: "trueaxis-campaign",
    version: 1,
    noun: "a campaign",
};

/// The JSON Schema of `campaign.json`.
pub fn schema() -> String {
    FORMAT.schema::<Document>()
}

/// A measuring campaign (`docs/formats.md`).
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: the campaign")]
pub(crate) struct Document {
    /// `trueaxis-campaign`.
    pub(crate) format: String,
    /// 1.
    pub(crate) version: u32,
    /// Name of the campaign.
    pub(crate) name: String,
    /// Day of the measurement, such as `2026-03-31`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) date: Option<String>,
    /// Who measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) operator: Option<String>,
    /// Nominal geometry of the machine.
    pub(crate) machine: MachineSpec,
    /// What is declared of the instrument.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) instrument: Option<Instrument>,
    /// Targets on the stages or on the bed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) targets: Vec<TargetEntry>,
    /// Stations of the tracker.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) stations: Vec<StationEntry>,
    /// Calibrated distances of targets of one stage.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) known_lengths: Vec<KnownLengthEntry>,
    /// Runs: sweeps of one axis.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) runs: Vec<RunEntry>,
    /// The table of lengths, relative to this file; this or `points`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) lengths: Option<String>,
    /// The table of points; this or `lengths`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) points: Option<String>,
    /// Readings of laser interferometers and ball bars, and point checks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) verification: Vec<VerificationEntry>,
}

/// Nominal geometry of the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: an axis")]
pub struct AxisSpec {
    /// Name, such as `X`.
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AxisKindSpec {
    /// Positions in mm.
    Linear,
    /// Positions in degrees.
    Rotary,
}

/// A target.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a target")]
pub(crate) struct TargetEntry {
    /// Name, such as `P`.
    pub(crate) name: String,
    /// Nominal position at home in the reference frame, mm.
    pub(crate) position_mm: [f64; 3],
    /// The outermost axis that moves it; null on the bed, which is not the same as a field left out.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(schema_with = "trueaxis_files::nullable_text")]
    pub(crate) carried_by: Option<String>,
    /// Name of the reflector in the nest; targets that name the same one share its constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) reflector: Option<String>,
    /// Standard deviation of each coordinate of the nest, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) position_sigma_mm: Option<f64>,
}

/// A station of the tracker.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a station")]
pub(crate) struct StationEntry {
    /// Name, such as `S1`.
    pub(crate) name: String,
    /// Rough position, mm; decides between mirror images.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) approx_mm: Option<[f64; 3]>,
    /// The dead path L, mm, where it is known: |p - S| = l + L.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) dead_path_mm: Option<f64>,
    /// Its standard uncertainty, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) dead_path_sigma_mm: Option<f64>,
}

/// A known distance.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a known length")]
pub(crate) struct KnownLengthEntry {
    /// The two targets.
    pub(crate) targets: [String; 2],
    /// Their calibrated distance, mm.
    pub(crate) length_mm: f64,
    /// Its standard uncertainty, µm.
    pub(crate) sigma_um: f64,
}

/// A run.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a run")]
pub(crate) struct RunEntry {
    /// Name, as in the tables.
    pub(crate) name: String,
    /// The axis that moves.
    pub(crate) axis: String,
}

/// All kinds of verification. Which fields belong to which kind is checked afterwards: a tagged
/// enum would lose the line and the path of what is wrong inside it.
#[derive(Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a verification")]
pub(crate) struct VerificationEntry {
    /// Name of the verification.
    pub(crate) name: String,
    /// What was read.
    pub(crate) kind: VerificationKindEntry,
    /// The axis of a laser line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) axis: Option<String>,
    /// The reflector of a laser line at home, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) target_mm: Option<[f64; 3]>,
    /// The moving ball of a ball bar at home, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ball_mm: Option<[f64; 3]>,
    /// The axis that carries it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) ball_carried_by: Option<String>,
    /// The other ball at home, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) center_mm: Option<[f64; 3]>,
    /// Whether readings of a ball bar are changes from the nominal distance of the balls (false).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) length_is_calibrated: Option<bool>,
    /// Constant part of the standard uncertainty of a reading, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) u_um: Option<f64>,
    /// Proportional part, µm per m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) u_ppm: Option<f64>,
    /// The table of readings, relative to this file.
    pub(crate) readings: String,
}

/// The kinds of verification.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(crate) enum VerificationKindEntry {
    /// Displacement along an axis against the commanded one.
    #[default]
    Positioning,
    /// Change of length between two balls.
    Ballbar,
    /// Deviations of the tool from where it was commanded.
    Points,
}
