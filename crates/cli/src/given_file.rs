//! Files that the command line names.

use std::io;
use std::path::{Path, PathBuf};

/// A file that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{} cannot be read; {wanted}", path.display())]
pub(crate) struct Unreadable {
    path: PathBuf,
    wanted: &'static str,
    pub(crate) source: io::Error,
}

impl Unreadable {
    /// The error for this file; `wanted` says which file it should be.
    pub(crate) fn at(path: &Path, wanted: &'static str) -> impl Fn(io::Error) -> Self {
        move |source| Self {
            path: path.to_owned(),
            wanted,
            source,
        }
    }
}

/// The text of a file; `wanted` says which file it should be.
pub(crate) fn read_text(path: &Path, wanted: &'static str) -> Result<String, Unreadable> {
    std::fs::read_to_string(path).map_err(Unreadable::at(path, wanted))
}
