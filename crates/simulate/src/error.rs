//! What can be wrong with a scenario.

use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::{Noise, Scenario};

/// A scenario that cannot be read or simulated, or a truth that cannot be written.
///
/// `field` is the path of the field in the scenario, as `runs[1].axis`. Errors of a scenario that
/// was read from text come as [`Error::At`], which adds the line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file of the scenario cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// The truth cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
    /// Where in the text the error that follows was found.
    #[error("{place}")]
    At {
        /// File and line.
        place: Place,
        /// What is wrong there.
        #[source]
        source: Box<Self>,
    },
    /// The text is not JSON, or not of the shape of a scenario.
    #[error("{}{message}{}", prefix(field.as_deref()), did_you_mean(nearest.as_deref()))]
    Json {
        /// Path of the innermost field that was being read.
        field: Option<String>,
        /// What the parser says.
        message: String,
        /// The known name closest to an unknown one.
        nearest: Option<String>,
    },
    /// The file is something else.
    #[error("format: expected `{}`, found {}", Scenario::FORMAT, named(found))]
    Format {
        /// What it calls itself; empty if it does not say.
        found: String,
    },
    /// The file is of another version.
    #[error(
        "version: expected {} of the scenario format, found {found}",
        Scenario::VERSION
    )]
    Version {
        /// Version of the file.
        found: u32,
    },
    /// A number that is not possible here.
    #[error("{field}: expected {expected}, found {value}")]
    Value {
        /// Path of the field.
        field: String,
        /// The number.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// Something else than what is there is expected.
    #[error("{field}: expected {expected}")]
    Expected {
        /// Path of the field.
        field: String,
        /// What is expected.
        expected: String,
    },
    /// Positions that do not increase.
    #[error("{field}: positions must increase, but {after} follows {before}")]
    NotIncreasing {
        /// Path of the later position.
        field: String,
        /// The earlier position.
        before: f64,
        /// The later position.
        after: f64,
    },
    /// A name that nothing has.
    #[error("{field}: no {what} is named `{name}` (known: {known}){}", did_you_mean(nearest.as_deref()))]
    UnknownName {
        /// Path of the field.
        field: String,
        /// What the name should stand for.
        what: &'static str,
        /// The name.
        name: String,
        /// The known name closest to it.
        nearest: Option<String>,
        /// All known names.
        known: String,
    },
    /// A name that is used twice.
    #[error("{field}: there is another {what} named `{name}`")]
    DuplicateName {
        /// Path of the second one.
        field: String,
        /// What it stands for.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// The machine's geometry is impossible.
    #[error("{field}: the machine cannot be built")]
    Machine {
        /// Path of the part.
        field: String,
        /// Why.
        #[source]
        source: trueaxis_kinematics::Error,
    },
    /// A commanded position that the axis cannot reach.
    #[error("{field}: position {position} of axis {axis} is outside its travel [{low}, {high}]")]
    OutsideTravel {
        /// Path of the position or the sweep.
        field: String,
        /// Name of the axis.
        axis: String,
        /// The position, mm or deg.
        position: f64,
        /// Lower end of the travel, mm or deg.
        low: f64,
        /// Upper end of the travel, mm or deg.
        high: f64,
    },
    /// A run measures a target that its axis does not move.
    #[error("{field}: axis {axis} does not move target {target}, which {carrier} carries")]
    TargetAtRest {
        /// Path of the target's name in the run.
        field: String,
        /// The axis of the run.
        axis: String,
        /// Name of the target.
        target: String,
        /// The outermost axis that moves the target.
        carrier: String,
    },
    /// A target that no run measures.
    #[error("{field}: no run measures target {target}; name it in a run or remove it")]
    TargetUnused {
        /// Path of the target.
        field: String,
        /// Name of the target.
        target: String,
    },
    /// Errors of an axis whose gauge is undefined because it never moves.
    #[error(
        "{field}: axis {axis} has errors, but no run moves it, so nothing defines what its \
         location errors and its component errors are; add a run, or set `gauge` to `none`"
    )]
    NoRun {
        /// Path of the errors.
        field: String,
        /// Name of the axis.
        axis: String,
    },
    /// Too few different positions to separate location errors from component errors.
    #[error(
        "{field}: the {count} commanded positions of axis {axis} cannot separate its location \
         errors from its component errors; run it at more positions, or set `gauge` to `none`"
    )]
    GaugeUndefined {
        /// Path of the errors.
        field: String,
        /// Name of the axis.
        axis: String,
        /// Number of different positions.
        count: usize,
    },
    /// Lost motion of an axis that is not swept in both directions.
    #[error(
        "{field}: lost motion of axis {axis} is the difference between both directions, but run \
         {run} sweeps one; set its `directions` to [1, -1]"
    )]
    LostMotionUnseen {
        /// Path of the lost motion.
        field: String,
        /// Name of the axis.
        axis: String,
        /// Name of the run.
        run: String,
    },
    /// A location error that is zero by definition of the reference frame.
    #[error("{field}: {name} = {value} {unit} must be zero, because {reason}")]
    TakenByFrame {
        /// Path of the location error.
        field: String,
        /// Its name.
        name: String,
        /// Its value.
        value: f64,
        /// mm or arcsec.
        unit: &'static str,
        /// What defines the frame.
        reason: String,
    },
    /// Mounting errors that move the origin of the reference frame.
    #[error(
        "targets: the mounting errors of {targets} have the mean [{x}, {y}, {z}] mm, but the \
         reference frame has its origin where that mean is zero; mended: {mended}",
        x = mean_mm[0], y = mean_mm[1], z = mean_mm[2]
    )]
    MountingMean {
        /// Names of the targets that define the frame.
        targets: String,
        /// Mean of true minus nominal positions, mm.
        mean_mm: [f64; 3],
        /// Mounting errors that differ by a rigid motion and pass.
        mended: String,
    },
    /// Mounting errors that turn the reference frame.
    #[error(
        "targets: the mounting errors of {targets} hold the rotation [{x:.3e}, {y:.3e}, {z:.3e}] rad \
         about their centroid, but without two linear runs the reference frame is the one in which \
         that rotation is zero; mended: {mended}",
        x = rotation_rad[0], y = rotation_rad[1], z = rotation_rad[2]
    )]
    MountingRotation {
        /// Names of the targets that define the frame.
        targets: String,
        /// Best-fit rotation vector, rad.
        rotation_rad: [f64; 3],
        /// Mounting errors that differ by a rigid motion and pass.
        mended: String,
    },
    /// Exact lengths were asked for together with noise.
    #[error(
        "noise.exact: lengths are exact only without noise, but length_sigma_um = {a}, \
         length_sigma_ppm = {b} and repeatability_um = {m}; set all three to 0 in `noise`",
        a = noise.length_sigma_um, b = noise.length_sigma_ppm, m = noise.repeatability_um
    )]
    ExactWithNoise {
        /// The noise asked for.
        noise: Noise,
    },
    /// An effect that the scenario's measurement cannot have.
    #[error(transparent)]
    Effect(#[from] trueaxis_effects::Error),
}

impl Error {
    /// Path of the field that is wrong, where it is one field.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Read { .. } | Self::Write { .. } => None,
            Self::Json { field, .. } => field.as_deref(),
            Self::At { source, .. } => source.field(),
            Self::Effect(error) => error.field(),
            Self::Format { .. } => Some("format"),
            Self::Version { .. } => Some("version"),
            Self::MountingMean { .. } | Self::MountingRotation { .. } => Some("targets"),
            Self::ExactWithNoise { .. } => Some("noise.exact"),
            Self::Value { field, .. }
            | Self::Expected { field, .. }
            | Self::NotIncreasing { field, .. }
            | Self::UnknownName { field, .. }
            | Self::DuplicateName { field, .. }
            | Self::Machine { field, .. }
            | Self::OutsideTravel { field, .. }
            | Self::TargetAtRest { field, .. }
            | Self::TargetUnused { field, .. }
            | Self::NoRun { field, .. }
            | Self::GaugeUndefined { field, .. }
            | Self::LostMotionUnseen { field, .. }
            | Self::TakenByFrame { field, .. } => Some(field),
        }
    }
}

/// A line of a text, and the file if it came from one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The file.
    pub file: Option<PathBuf>,
    /// Line, from 1.
    pub line: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{} ", file.display())?;
        }
        write!(f, "line {}", self.line)
    }
}

fn named(found: &str) -> String {
    if found.is_empty() {
        "no `format`".to_owned()
    } else {
        format!("`{found}`")
    }
}

fn prefix(field: Option<&str>) -> String {
    field.map_or_else(String::new, |field| format!("{field}: "))
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
