//! The scenario: a machine with known errors, an instrument and a measuring plan.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_campaign::{Instrument, MachineSpec};
use trueaxis_effects::GivenEffect;
use trueaxis_files::{Format, unique_keys};

use crate::{KnownLengthSpec, ReflectorSpec, SystematicSpec, TemperatureSpec, Term};

/// What is to be simulated, as `scenario.json` says it.
///
/// Plain data in the units of the file: mm, degrees, µm and arc seconds by name. Read it with
/// [`Scenario::read`] or [`Scenario::from_json`]; [`crate::simulate()`] checks it. Written as JSON
/// (`trueaxis_files::to_json`) it can be read back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: the scenario")]
pub struct Scenario {
    /// The name of [`Scenario::FORMAT`].
    pub format: String,
    /// The version of [`Scenario::FORMAT`].
    pub version: u32,
    /// Name of the campaign.
    pub name: String,
    /// Nominal geometry, as in `campaign.json`.
    pub machine: MachineSpec,
    /// As in `campaign.json`; its declared noise is the true noise too, unless `noise` differs.
    #[serde(default)]
    pub instrument: Instrument,
    /// Targets on the stages.
    pub targets: Vec<TargetSpec>,
    /// Stations of the tracker.
    pub stations: Vec<StationSpec>,
    /// True errors by name of the axis; an axis that is not named has none.
    #[serde(default, deserialize_with = "unique_keys")]
    pub errors: BTreeMap<String, AxisErrors>,
    /// Whether the error curves are put into the least-squares gauge.
    #[serde(default)]
    pub gauge: Gauge,
    /// What disturbs the readings beyond the rigid, quasi-static machine. Instants are on the clock
    /// of the campaign, the `time_s` of `lengths.csv`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<GivenEffect>,
    /// Sweeps of single axes, in measuring order.
    pub runs: Vec<RunSpec>,
    /// How often all runs are measured from each station.
    #[serde(default = "once")]
    pub repeats: u32,
    /// When targets on the bed are read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bed: Option<BedSpec>,
    /// True noise where it differs from what the instrument declares.
    #[serde(default)]
    pub noise: NoiseSpec,
    /// True standard deviations of what is drawn once for the campaign where they differ from what is
    /// declared.
    #[serde(default, skip_serializing_if = "SystematicSpec::is_as_declared")]
    pub systematic: SystematicSpec,
    /// Reflectors whose constants are given and not drawn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reflectors: Vec<ReflectorSpec>,
    /// Calibrated distances between targets that the campaign declares.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub known_lengths: Vec<KnownLengthSpec>,
    /// Temperatures that are logged with the lengths.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub temperatures: Vec<TemperatureSpec>,
    /// The clock.
    #[serde(default)]
    pub timing: Timing,
}

impl Scenario {
    /// The format that this crate reads.
    pub const FORMAT: Format = Format {
        name: "trueaxis-scenario",
        version: 1,
        noun: "a scenario",
    };

    /// The JSON Schema of `scenario.json`.
    pub fn schema() -> String {
        Self::FORMAT.schema::<Self>()
    }
}

/// A target on a stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a target")]
pub struct TargetSpec {
    /// Name, such as `P`.
    pub name: String,
    /// Nominal position at home in the reference frame, mm.
    pub position_mm: [f64; 3],
    /// The outermost axis that moves it; null on the bed, where [`Scenario::bed`] reads it.
    #[serde(deserialize_with = "Option::deserialize")]
    #[schemars(schema_with = "trueaxis_files::nullable_text")]
    pub carried_by: Option<String>,
    /// True minus nominal position at home, mm.
    #[serde(default)]
    pub mounting_error_mm: [f64; 3],
    /// Name of its reflector, as the campaign declares it; targets that name the same share its constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reflector: Option<String>,
    /// Standard deviation of its nest as the campaign declares it, mm per coordinate: the nest has a
    /// random error of this size in addition to `mounting_error_mm`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_sigma_mm: Option<f64>,
}

/// When targets on the bed are read from each station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: targets on the bed")]
pub struct BedSpec {
    /// How often all of them are read: once at the start of the occupation, once at its end, and otherwise
    /// evenly between sweeps.
    pub readings: u32,
}

/// A station of the tracker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a station")]
pub struct StationSpec {
    /// Name, such as `S1`.
    pub name: String,
    /// True position in the reference frame, mm.
    pub position_mm: [f64; 3],
    /// True dead path L: the tracker shows `|p - S| - L`, mm.
    pub dead_path_mm: f64,
    /// Whether the campaign file gives `approx_mm`: the true position rounded to 100 mm, as one
    /// paces it off.
    #[serde(default)]
    pub declare_approx: bool,
    /// If given, the campaign file gives the dead path with this standard uncertainty, mm, and a random
    /// error of this size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dead_path_sigma_mm: Option<f64>,
}

/// The true errors of one axis.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: the errors of an axis")]
pub struct AxisErrors {
    /// Curves by ISO 230-1 name, such as `EXX`: the sum of the terms, µm or arcsec.
    #[serde(default, deserialize_with = "unique_keys")]
    pub components: BTreeMap<String, Vec<Term>>,
    /// Location errors by ISO 230-1 name, such as `C0Y`.
    #[serde(default, deserialize_with = "unique_keys")]
    pub location_errors: BTreeMap<String, LocationValue>,
    /// Lost motion b of a linear axis, µm: the stage stands at `-b/2` along the axis direction
    /// when it arrives in positive direction, at `+b/2` when it arrives in negative direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost_motion_um: Option<f64>,
    /// The same for a rotary axis, arcsec about the axis direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost_motion_arcsec: Option<f64>,
}

/// One location error: an angle or a shift.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "an object as { \"value_arcsec\": 12 } or { \"value_mm\": 0.02 }"
)]
pub struct LocationValue {
    /// A tilt, arcsec (right-hand rule).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value_arcsec: Option<f64>,
    /// A shift of a rotary axis, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value_mm: Option<f64>,
}

/// What is done to the curves before they are simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gauge {
    /// Mean, slope and home value are taken out so that the location errors of the scenario are
    /// those of the average lines and axes.
    #[default]
    LeastSquares,
    /// The curves are simulated as they are given.
    None,
}

/// A sweep of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: a run")]
pub struct RunSpec {
    /// Name, such as `x`.
    pub name: String,
    /// The axis that moves.
    pub axis: String,
    /// Commanded positions, increasing, mm or deg; this or `sweep`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub positions: Option<Vec<f64>>,
    /// Evenly spaced positions; this or `positions`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Where other axes are parked, mm or deg; 0 where not named.
    #[serde(default, deserialize_with = "unique_keys")]
    pub parked: BTreeMap<String, f64>,
    /// Targets measured at every stop, in this order; all that the axis moves if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub targets: Option<Vec<String>>,
    /// Sides of approach: 1 sweeps up, -1 sweeps down, in this order.
    #[serde(default = "upwards")]
    pub directions: Vec<i8>,
}

/// Positions `start, start + step, ..., stop`, mm or deg.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "an object as { \"start\": 0, \"stop\": 400, \"step\": 20 }"
)]
pub struct Sweep {
    /// First position.
    pub start: f64,
    /// Last position, reached exactly.
    pub stop: f64,
    /// Distance of neighbours, positive.
    pub step: f64,
}

/// True noise; what is not given is as the instrument declares.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "an object: the instrument")]
pub struct NoiseSpec {
    /// Constant part of a length's standard deviation, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_sigma_um: Option<f64>,
    /// Proportional part of a length's standard deviation, µm per m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_sigma_ppm: Option<f64>,
    /// Standard deviation per coordinate of the position that the machine returns to, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeatability_um: Option<f64>,
    /// Lengths are left unrounded; only allowed when all noise is zero.
    #[serde(default)]
    pub exact: bool,
}

impl NoiseSpec {
    /// None at all: lengths are exact, whatever the instrument declares.
    pub const NONE: Self = Self {
        length_sigma_um: Some(0.0),
        length_sigma_ppm: Some(0.0),
        repeatability_um: Some(0.0),
        exact: true,
    };
}

/// When readings are taken. The clock starts at `start_s` at the first station.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object: the timing")]
pub struct Timing {
    /// Start of the campaign, s.
    pub start_s: f64,
    /// From one reading to the next of the same stop, s.
    pub per_reading_s: f64,
    /// For a move to the next stop, before its first reading, s.
    pub per_move_s: f64,
    /// For carrying the tracker to the next station, s.
    pub per_station_change_s: f64,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            start_s: 0.0,
            per_reading_s: 2.0,
            per_move_s: 4.0,
            per_station_change_s: 900.0,
        }
    }
}

fn once() -> u32 {
    1
}

fn upwards() -> Vec<i8> {
    vec![1]
}
