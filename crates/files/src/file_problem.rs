//! Reading a file that somebody names.

use std::io;
use std::path::Path;

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FileProblem {
    /// There is no such file.
    #[error("there is no such file; {hint}")]
    NotFound {
        /// Who names the file, or what to give instead.
        hint: String,
    },
    /// A folder stands where a file is needed.
    #[error("this is a folder, expected a file; {hint}")]
    Folder {
        /// Who names the file, or what to give instead.
        hint: String,
    },
    /// The operating system refuses to read the file.
    #[error("the file cannot be read; check its permissions")]
    Unreadable {
        /// The reason of the operating system.
        source: io::Error,
    },
}

/// The bytes of a file; `hint` says what to do if it is not there.
pub fn read_bytes(file: &Path, hint: &str) -> Result<Vec<u8>, FileProblem> {
    let hint = || hint.to_owned();
    if file.is_dir() {
        return Err(FileProblem::Folder { hint: hint() });
    }
    std::fs::read(file).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => FileProblem::NotFound { hint: hint() },
        _ => FileProblem::Unreadable { source },
    })
}
