//! The checked campaign: what was measured, on which machine, with what.

use std::ops::Range;

use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueaxis_kinematics::Machine;

use crate::LoggedColumn;

/// A measuring campaign that has been read and checked.
///
/// Every index in it (station, target, run, step, axis) is valid. Inside, lengths are mm, angles
/// and rotary positions rad, times s; only fields named `_um` or `_ppm` differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// Name of the campaign.
    pub name: String,
    /// Day of the measurement as `YYYY-MM-DD`, if it is given; never the computer's clock.
    pub date: Option<String>,
    /// Who measured, if it is given.
    pub operator: Option<String>,
    /// Name of the machine.
    pub machine_name: String,
    /// Its axes and branches.
    pub machine: Machine,
    /// Declared thermal expansion of linear axes, at most one for an axis, in the order of the axes.
    pub expansions: Vec<AxisExpansion>,
    /// The instrument with its declared noise and uncertainties.
    pub instrument: Instrument,
    /// Targets in the order of the file.
    pub targets: Vec<Target>,
    /// Stations of the tracker in the order of the file; empty for a points campaign.
    pub stations: Vec<Station>,
    /// Calibrated distances between targets.
    pub known_lengths: Vec<KnownLength>,
    /// Runs in the order of the file.
    pub runs: Vec<Run>,
    /// Commanded positions: one step for each different position of a run, and one without a run for each at which
    /// targets on the bed were read.
    pub steps: Vec<Step>,
    /// Lengths of a multilateration campaign.
    pub lengths: Option<Lengths>,
    /// Coordinates of a points campaign.
    pub points: Option<Points>,
    /// Measurements of other instruments, to compare with.
    pub verification: Vec<Verification>,
    /// Measured deviations of the tool at single places, to compare with.
    pub point_checks: Vec<PointCheck>,
    /// What is unusual but not an error, as messages for the user.
    pub notices: Vec<String>,
}

/// Name, declared noise and systematic uncertainties. What is `None` was not declared.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "an object: the instrument")]
pub struct Instrument {
    /// Name of the instrument.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Constant part of a length's standard deviation, µm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_sigma_um: Option<f64>,
    /// Proportional part of a length's standard deviation, µm per m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_sigma_ppm: Option<f64>,
    /// Standard deviation per coordinate of the position that the machine returns to, µm; common
    /// to the targets measured at one stop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeatability_um: Option<f64>,
    /// Standard deviation of the constants of a set of reflectors, µm along the beam. A reflector
    /// with the constant c shows every length longer by c.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflector_sigma_um: Option<f64>,
    /// Standard uncertainty of the scale of all lengths together, µm per m: systematic, common to
    /// the campaign, no noise of single lengths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scale_sigma_ppm: Option<f64>,
    /// Whether the instrument corrects lengths for the refractive index of the air itself; true if it is not given.
    #[serde(skip_serializing_if = "is_true")]
    pub air_compensated: bool,
}

impl Instrument {
    /// Whether both parts of the noise of lengths are declared: one alone can be tested against nothing.
    pub fn declares_noise(&self) -> bool {
        self.length_sigma_um.is_some() && self.repeatability_um.is_some()
    }
}

impl Default for Instrument {
    fn default() -> Self {
        Self {
            name: String::new(),
            serial: None,
            length_sigma_um: None,
            length_sigma_ppm: None,
            repeatability_um: None,
            reflector_sigma_um: None,
            scale_sigma_ppm: None,
            air_compensated: true,
        }
    }
}

fn is_true(value: &bool) -> bool {
    *value
}

/// Thermal expansion of a linear axis: at the temperature T its scale is `α (T - 20 °C)` longer.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisExpansion {
    /// The axis.
    pub axis: usize,
    /// Coefficient α, µm per m and K.
    pub ppm_per_k: f64,
    /// The column of `lengths.csv` that holds the temperature T of the axis, °C; there is one of that
    /// name where the campaign has lengths.
    pub temperature_column: String,
    /// Standard uncertainty of that temperature as the axis', K.
    pub temperature_sigma_k: Option<f64>,
    /// The temperature that the lengths have been referred to, °C; none where they are as measured.
    pub lengths_hold_at_c: Option<f64>,
}

impl AxisExpansion {
    /// The temperature column of an axis that names none.
    pub const DEFAULT_COLUMN: &str = "machine_temp_c";
}

/// A calibrated distance between two targets of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownLength {
    /// The two targets.
    pub targets: [usize; 2],
    /// Their distance, mm.
    pub length_mm: f64,
    /// Its standard uncertainty, µm.
    pub sigma_um: f64,
}

/// A target on a stage, or on the bed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Target {
    /// Name, such as `P`.
    pub name: String,
    /// Nominal position at home in the reference frame, mm.
    pub home_mm: Point3<f64>,
    /// The outermost axis that moves it; none on the bed.
    pub carrier: Option<usize>,
    /// Name of the reflector in its nest, if it is given; see [`Campaign::reflectors`].
    pub reflector: Option<String>,
    /// Standard deviation of each coordinate of `home_mm`, independent, mm: how well the nest was set.
    pub position_sigma_mm: Option<f64>,
}

/// A station of the tracker, on the bed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Station {
    /// Name, such as `S1`.
    pub name: String,
    /// Rough position in the reference frame, mm; not needed to solve.
    pub approx_mm: Option<Point3<f64>>,
    /// Its dead path, where it is known.
    pub dead_path: Option<KnownDeadPath>,
}

/// A dead path L that is known (absolute distance meter): `|p - S| = l + L`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownDeadPath {
    /// L, mm.
    pub length_mm: f64,
    /// Its standard uncertainty, mm.
    pub sigma_mm: f64,
}

/// One sweep of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Name, such as `x`.
    pub name: String,
    /// The axis under test.
    pub axis: usize,
}

/// A commanded position of a run. Its points are common to all stops there.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Its run; none where targets on the bed were read, which is not a pose of an axis.
    pub run: Option<usize>,
    /// Commanded positions of all axes, mm or rad, in the order of the machine's axes.
    pub positions: Vec<f64>,
}

/// From which side a position was approached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Direction {
    /// -1 in the files.
    Backward,
    /// +1 in the files.
    Forward,
}

impl Direction {
    /// -1 or +1, as in the files.
    pub fn sign(self) -> i8 {
        match self {
            Self::Backward => -1,
            Self::Forward => 1,
        }
    }
}

/// One visit of the machine to a step: the readings taken there without moving.
#[derive(Debug, Clone, PartialEq)]
pub struct Stop {
    /// Station of the tracker; 0 in a points campaign.
    pub station: usize,
    /// Repeat, from 1.
    pub repeat: u32,
    /// Its step (which knows the run).
    pub step: usize,
    /// Side of approach; forward, without meaning, where targets on the bed were read.
    pub direction: Direction,
    /// Its readings.
    pub readings: Range<usize>,
}

/// The rows of `lengths.csv`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lengths {
    /// Stops in measuring order; their ranges cover `readings` without gaps.
    pub stops: Vec<Stop>,
    /// Readings in measuring order.
    pub readings: Vec<LengthReading>,
    /// Air and machine state at the readings: one entry for each such column of the file, in its order.
    pub logged: Vec<LoggedColumn>,
}

impl Campaign {
    /// The axis under test at a step; none where targets on the bed were read.
    pub fn axis_under_test(&self, step: usize) -> Option<usize> {
        self.steps[step].run.map(|run| self.runs[run].axis)
    }
}

impl Lengths {
    /// The logged column of that name, such as `machine_temp_spindle_c`.
    pub fn logged_column(&self, name: &str) -> Option<&LoggedColumn> {
        self.logged.iter().find(|column| column.name == name)
    }

    /// Time and value of each reading with which a value was logged in `column`.
    pub fn course(&self, column: &LoggedColumn) -> Vec<(f64, f64)> {
        let times = self.readings.iter().map(|reading| reading.time_s);
        let values = times.zip(&column.values);
        values.filter_map(|(t, v)| Some((t, (*v)?))).collect()
    }
}

/// One length.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthReading {
    /// Time since the start of the campaign, s.
    pub time_s: f64,
    /// Target measured.
    pub target: usize,
    /// Incremental length `|p - S| - L`, mm.
    pub length_mm: f64,
    /// Line of the file, from 1 (the header).
    pub line: usize,
}

/// The rows of `points.csv`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Points {
    /// Stops in measuring order; their ranges cover `readings` without gaps.
    pub stops: Vec<Stop>,
    /// Readings in measuring order.
    pub readings: Vec<PointReading>,
}

/// One measured point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointReading {
    /// Time since the start of the campaign, s.
    pub time_s: f64,
    /// Target measured.
    pub target: usize,
    /// Position in the instrument's frame, mm.
    pub position_mm: Point3<f64>,
    /// Standard deviation per coordinate, µm.
    pub sigma_um: Option<f64>,
    /// Line of the file, from 1 (the header).
    pub line: usize,
}

/// Measurements of another instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// Name, such as `LI along X`.
    pub name: String,
    /// What was measured.
    pub kind: VerificationKind,
    /// Constant part of the standard uncertainty of a reading, µm.
    pub u_um: Option<f64>,
    /// Proportional part, µm per m: of the commanded position of the axis, or of the nominal length of the bar.
    pub u_ppm: Option<f64>,
    /// Its readings in measuring order.
    pub readings: Vec<VerificationReading>,
}

/// The two kinds of verification.
#[derive(Debug, Clone, PartialEq)]
pub enum VerificationKind {
    /// Deviation of the displacement of a point along an axis (laser interferometer).
    Positioning {
        /// The axis measured.
        axis: usize,
        /// The measured point at home in the reference frame, mm.
        target_mm: Point3<f64>,
    },
    /// Change of length of a ball bar (paper Eq. 24).
    Ballbar {
        /// The moving ball at home in the reference frame, mm.
        ball_mm: Point3<f64>,
        /// The outermost axis that moves the ball.
        ball_carrier: usize,
        /// The fixed ball in the reference frame, mm.
        center_mm: Point3<f64>,
        /// Whether readings are changes from the nominal distance of the balls, as of a bar whose length is calibrated; otherwise
        /// their zero is anywhere.
        length_is_calibrated: bool,
    },
}

/// One row of a readings file.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationReading {
    /// Time, s, where the file has it; else the order of rows is the clock.
    pub time_s: Option<f64>,
    /// Cycle, from 1.
    pub cycle: u32,
    /// Side of approach.
    pub direction: Direction,
    /// Commanded positions of all axes, mm or rad.
    pub positions: Vec<f64>,
    /// `deviation_um` or `delta_um`, µm.
    pub value_um: f64,
    /// Line of the file, from 1 (the header).
    pub line: usize,
}

/// Deviations of the tool from where it was commanded, at single places.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCheck {
    /// Name, such as `ball plate`.
    pub name: String,
    /// Constant part of the standard uncertainty of a coordinate, µm.
    pub u_um: Option<f64>,
    /// Proportional part, µm per m of the commanded distance from home.
    pub u_ppm: Option<f64>,
    /// Its places in measuring order.
    pub readings: Vec<PointCheckReading>,
}

/// One row of a table of point checks.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCheckReading {
    /// Time, s, where the file has it; else the order of rows is the clock.
    pub time_s: Option<f64>,
    /// Cycle, from 1, where the file has it.
    pub cycle: Option<u32>,
    /// Commanded positions of all axes, mm or rad.
    pub positions: Vec<f64>,
    /// The point of the tool in the reference frame at home, mm; `None` if the table has no columns for it.
    pub tool_home_mm: Option<Point3<f64>>,
    /// Actual minus commanded place along x, y and z of the workpiece at home, which turn with it, µm; at least one is measured.
    pub deviation_um: [Option<f64>; 3],
    /// Line of the file, from 1 (the header).
    pub line: usize,
}
