//! What is wrong in a file, and where.

use std::fmt;
use std::path::Path;

use crate::{DocumentError, DocumentProblem, Part, Place};

/// A problem with its place: where, what was found, what is expected and how to correct it.
#[derive(Debug, Clone, PartialEq)]
pub struct Located<P> {
    /// Where.
    pub place: Box<Place>,
    /// What is wrong there.
    pub problem: P,
}

impl<P: fmt::Display> fmt::Display for Located<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place.to_string().as_str() {
            "" => write!(f, "{}", self.problem),
            place => write!(f, "{place}: {}", self.problem),
        }
    }
}

impl<P: std::error::Error> std::error::Error for Located<P> {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.problem.source()
    }
}

impl<P> Located<P> {
    /// The same problem, found in that file.
    #[must_use]
    pub fn in_file(mut self, file: &Path) -> Self {
        self.place.file = Some(file.to_owned());
        self
    }

    /// The same problem where its field is a part of the field `outer`.
    #[must_use]
    pub fn within(mut self, outer: &str) -> Self {
        if let Some(Part::Field(path)) = &mut self.place.part {
            *path = format!("{outer}.{path}");
        }
        self
    }
}

/// Problems among which are those of documents.
pub trait OfDocument {
    /// This one.
    fn of_document(problem: DocumentProblem) -> Self;
}

impl<P: OfDocument> From<DocumentError> for Located<P> {
    fn from(DocumentError { place, problem }: DocumentError) -> Self {
        let problem = P::of_document(problem);
        Self { place, problem }
    }
}
