//! What can be wrong with the files of a calibration.

use std::path::PathBuf;

use trueaxis_files::{DocumentError, FileProblem, NpzError};

/// A calibration that cannot be read from its files.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum ReadError {
    /// A file cannot be read.
    #[error("{}: {problem}", path.display())]
    File { path: PathBuf, problem: FileProblem },
    /// `calibration.json` is wrong.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// Its machine is wrong.
    #[error(transparent)]
    Machine(#[from] trueaxis_campaign::Error),
    /// The covariance is wrong.
    #[error(
        "{}: {problem}; keep the two files of a calibration together, or calibrate the campaign again",
        path.display()
    )]
    Covariance {
        path: PathBuf,
        problem: CovarianceProblem,
    },
}

/// What can be wrong with `covariance.npz`.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum CovarianceProblem {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] NpzError),
    /// An array is not there.
    #[error("array `{name}` is missing")]
    NoArray { name: &'static str },
    /// An array of another size: another calibration.
    #[error(
        "array `{name}` has the shape {found:?}, expected {expected} for the results of this calibration.json"
    )]
    Shape {
        name: &'static str,
        found: Vec<usize>,
        expected: String,
    },
    /// An array with something that is no number.
    #[error("array `{name}` has elements that are not finite")]
    NotFinite { name: &'static str },
    /// Its uncertainties are others.
    #[error(
        "the standard uncertainty of {result} is {found:.6}, in calibration.json {expected:.6}"
    )]
    OtherUncertainty {
        result: String,
        found: f64,
        /// That of `calibration.json`.
        expected: f64,
    },
}
