//! Why points do not determine six component errors.

use crate::SixRows;

/// Points that do not determine the six component errors, or malformed input.
///
/// Targets and rows of a covariance are counted from 0 in the order in which they were given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// Fewer than three targets.
    #[error("need at least 3 targets to see all six component errors, found {found}")]
    TooFewTargets { found: usize },
    /// A coordinate or a volumetric error is NaN or infinite.
    #[error("the {quantity} of target number {target} (from 0) is not finite")]
    NotFinite {
        quantity: &'static str,
        target: usize,
    },
    /// All targets lie on one line, or at one point.
    #[error(
        "the targets lie on one line: the farthest two are {length_mm:.4} mm apart and none is more \
         than {off_line_mm:.6} mm away from the line through them, so that the rotation about this \
         line is not seen"
    )]
    Collinear { length_mm: f64, off_line_mm: f64 },
    /// The covariance does not have three rows and three columns for each target.
    #[error("the covariance of the points is {rows} x {columns}, expected {expected} x {expected}")]
    CovarianceShape {
        rows: usize,
        columns: usize,
        expected: usize,
    },
    /// The covariance is not symmetric, or holds a number that is not finite.
    #[error(
        "the covariance of the points is not symmetric: entry ({row}, {column}) is {upper} mm² \
         and its mirror image is {lower} mm²"
    )]
    CovarianceAsymmetric {
        row: usize,
        /// Column of the entry, at or right of the diagonal.
        column: usize,
        upper: f64,
        lower: f64,
    },
    /// The covariance is not positive definite; for [`crate::rigid_misfit`] the part of it that no rigid motion
    /// reaches.
    #[error(
        "the covariance of the points is not positive definite: its eigenvalues reach from \
         {smallest_mm2} to {largest_mm2} mm²"
    )]
    Covariance { smallest_mm2: f64, largest_mm2: f64 },
    /// Not a choice of six different rows out of nine.
    #[error("{rows:?} is not a choice of six different rows from 0 to 8")]
    RowChoice { rows: [usize; 6] },
    /// A choice of rows that is singular for these targets.
    #[error(
        "equations {rows} are singular for these targets: condition number {condition:.3e}, \
         determinant {determinant_mm3:.3e} mm³; all nine may not be"
    )]
    SingularRows {
        rows: SixRows,
        /// Condition number of the centred and scaled six equations.
        condition: f64,
        /// Determinant of the six equations, mm³; for [`SixRows::PAPER`] it is the paper's N.
        determinant_mm3: f64,
    },
    /// A choice of rows so nearly singular at a step that the distortion of its points leaves no pose.
    #[error(
        "equations {rows} are near singular for these targets, condition number {condition:.0}: no pose gives the \
         six coordinates that were measured"
    )]
    NearSingularRows {
        rows: SixRows,
        /// Condition number of the centred and scaled six equations in the nominal pose.
        condition: f64,
    },
    /// Newton's method on a pose did not converge.
    #[error(
        "no pose fits the points: after {iterations} steps from the nominal pose the next one would \
         still move a target by {step_mm:.3e} mm"
    )]
    NoPose { iterations: usize, step_mm: f64 },
    /// The numbers of nominal and measured targets differ.
    #[error("{nominal} nominal and {measured} measured targets cannot be compared")]
    TargetCount { nominal: usize, measured: usize },
}

/// A step that gives no pose.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step}")]
pub struct StepError {
    /// Number of the step, from 0.
    pub step: usize,
    /// Why.
    #[source]
    pub error: Error,
}
