//! What can be wrong with a scenario.

use std::io;
use std::path::Path;

use trueaxis_files::{DocumentProblem, Located, OfDocument, Place, field_line};

use crate::Noise;

/// A scenario that cannot be read or simulated, or a truth that cannot be written.
///
/// Its message says where: the path of the field, such as `runs[1].axis`, and the line if the scenario was
/// read from text.
pub type Error = Located<Box<Problem>>;

/// The same error in a text, perhaps of a file.
pub(crate) fn in_text(mut error: Error, text: &str, file: Option<&Path>) -> Error {
    let field = error.place.field_path();
    error.place.line = Some(field.map_or(1, |field| field_line(text, field)));
    error.place.file = file.map(Path::to_owned);
    error
}

impl OfDocument for Box<Problem> {
    fn of_document(problem: DocumentProblem) -> Self {
        Self::new(Problem::Document(problem))
    }
}

impl Problem {
    /// The error with this problem in a field of the scenario.
    pub(crate) fn at(self, field: impl Into<String>) -> Error {
        self.in_place(Place::in_field(field))
    }

    /// The error with this problem somewhere.
    pub(crate) fn in_place(self, place: Box<Place>) -> Error {
        let problem = Box::new(self);
        Error { place, problem }
    }

    /// That of what a scenario shares with a campaign.
    pub(crate) fn of_campaign(error: trueaxis_campaign::Error) -> Error {
        Self::Campaign(error.problem).in_place(error.place)
    }
}

/// What can be wrong with a scenario. An [`Error`] says where it is.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Problem {
    /// The file of the scenario cannot be read.
    #[error("the file cannot be read")]
    Read(#[source] io::Error),
    /// The truth cannot be written.
    #[error("the file cannot be written")]
    Write(#[source] io::Error),
    /// Of the document, or a name in it.
    #[error(transparent)]
    Document(DocumentProblem),
    /// Of what a scenario shares with a campaign.
    #[error(transparent)]
    Campaign(trueaxis_campaign::Problem),
    /// A number that is not possible here.
    #[error("expected {expected}, found {value}")]
    Value { value: f64, expected: &'static str },
    /// Something else than what is there is expected.
    #[error("expected {expected}")]
    Expected { expected: String },
    /// Positions that do not increase.
    #[error("positions must increase, but {after} follows {before}")]
    NotIncreasing { before: f64, after: f64 },
    /// A commanded position that the axis cannot reach.
    #[error("position {position} of axis {axis} is outside its travel [{low}, {high}]")]
    OutsideTravel {
        axis: String,
        /// The position, mm or deg.
        position: f64,
        /// Lower end of the travel, mm or deg.
        low: f64,
        /// Upper end of the travel, mm or deg.
        high: f64,
    },
    /// A run measures a target that its axis does not move.
    #[error("axis {axis} does not move target {target}, which {carrier} carries")]
    TargetAtRest {
        axis: String,
        target: String,
        /// The outermost axis that moves the target, or the bed.
        carrier: String,
    },
    /// A target that no run measures.
    #[error("no run measures target {target}; name it in a run or remove it")]
    TargetUnused { target: String },
    /// Errors of an axis whose gauge is undefined because it never moves.
    #[error(
        "axis {axis} has errors, but no run moves it, so nothing defines what its \
         location errors and its component errors are; add a run, or set `gauge` to `none`"
    )]
    NoRun { axis: String },
    /// Too few different positions to separate location errors from component errors.
    #[error(
        "the {count} commanded positions of axis {axis} cannot separate its location \
         errors from its component errors; run it at more positions, or set `gauge` to `none`"
    )]
    GaugeUndefined { axis: String, count: usize },
    /// Lost motion of an axis that is not swept in both directions.
    #[error(
        "lost motion of axis {axis} is the difference between both directions, but run \
         {run} sweeps one; set its `directions` to [1, -1]"
    )]
    LostMotionUnseen { axis: String, run: String },
    /// A location error that is zero by definition of the reference frame.
    #[error("{name} = {value} {unit} must be zero, because {reason}")]
    TakenByFrame {
        name: String,
        value: f64,
        /// mm or arcsec.
        unit: &'static str,
        reason: String,
    },
    /// Mounting errors that move the origin of the reference frame.
    #[error(
        "the mounting errors of {targets} have the mean [{x:.6}, {y:.6}, {z:.6}] mm, but the \
         reference frame has its origin where that mean is zero; these would pass: {corrected}",
        x = mean_mm[0], y = mean_mm[1], z = mean_mm[2]
    )]
    MountingMean {
        targets: String,
        mean_mm: [f64; 3],
        /// Mounting errors that differ by a rigid motion and pass.
        corrected: String,
    },
    /// Mounting errors that turn the reference frame.
    #[error(
        "the mounting errors of {targets} contain the rotation [{x:.3e}, {y:.3e}, {z:.3e}] rad \
         about their centroid, but without two linear runs the reference frame is the one in which \
         that rotation is zero; these would pass: {corrected}",
        x = rotation_rad[0], y = rotation_rad[1], z = rotation_rad[2]
    )]
    MountingRotation {
        targets: String,
        rotation_rad: [f64; 3],
        /// Mounting errors that differ by a rigid motion and pass.
        corrected: String,
    },
    /// Exact lengths were asked for together with noise.
    #[error(
        "lengths are exact only without noise, but length_sigma_um = {a}, \
         length_sigma_ppm = {b} and repeatability_um = {m}; set all three to 0 in `noise`",
        a = noise.length_sigma_um, b = noise.length_sigma_ppm, m = noise.repeatability_um
    )]
    ExactWithNoise { noise: Noise },
    /// An effect that the scenario's measurement cannot have.
    #[error(transparent)]
    Effect(trueaxis_effects::Problem),
}
