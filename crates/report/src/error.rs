//! What keeps a folder from becoming a report.

use std::path::PathBuf;

/// A report that cannot be made.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Error {
    /// The folder holds no result.
    #[error(
        "{folder} holds neither {found}; give the folder that `trueaxis calibrate` or `trueaxis diagnose` wrote",
        folder = folder.display(),
        found = crate::input::RESULTS.join(" nor ")
    )]
    NothingToReport { folder: PathBuf },
    /// A file cannot be read.
    #[error("{file} cannot be read", file = file.display())]
    Unreadable {
        file: PathBuf,
        source: std::io::Error,
    },
    /// A JSON file is not what its name says.
    #[error("{file} is not a result of this program; write it again with `trueaxis`", file = file.display())]
    NotAResult {
        file: PathBuf,
        /// What is wrong, with line and column where there are any.
        source: serde_json::Error,
    },
    /// A result has another format or version.
    #[error(
        "{file} has the format `{found}`, but `{expected}` is expected; write it again with this version of `trueaxis`",
        file = file.display()
    )]
    OtherFormat {
        file: PathBuf,
        found: String,
        expected: String,
    },
    /// The residuals are no table as `trueaxis calibrate` writes it.
    #[error("{file} is not a table of residuals; write it again with `trueaxis calibrate`", file = file.display())]
    NotResiduals {
        file: PathBuf,
        /// What is wrong, with its line.
        source: csv::Error,
    },
    /// The template is wrong, or asks for what a report does not have.
    #[error(
        "the template fails; compare it with the program's own (crates/report/src/report.html)"
    )]
    Template { source: minijinja::Error },
}
