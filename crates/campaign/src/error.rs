//! A problem in the files of a campaign, with its place.

use std::fmt;
use std::path::Path;

use trueaxis_files::DocumentError;

use crate::{Place, Problem};

/// A campaign that cannot be read or written.
///
/// Its message says where, what was found, what is expected and how to correct it.
#[derive(Debug)]
pub struct Error {
    /// Where.
    pub place: Box<Place>,
    /// What is wrong there.
    pub problem: Problem,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.problem)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.problem.source()
    }
}

impl Error {
    /// The same error, found in that file.
    pub(crate) fn in_file(mut self, file: &Path) -> Self {
        self.place.file = Some(file.to_owned());
        self
    }
}

impl From<DocumentError> for Error {
    fn from(error: DocumentError) -> Self {
        Problem::Document(error.problem).at(error.place)
    }
}
