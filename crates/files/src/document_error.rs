//! What can be wrong with a document, whatever it is about.

use crate::{Alternatives, Format, Located, Place};

/// What is wrong with a document, and where.
pub type DocumentError = Located<DocumentProblem>;

/// What can be wrong with any document, with what was found and what is expected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum DocumentProblem {
    /// The text is not JSON.
    #[error(
        "not valid JSON: {problem}; expected JSON as in RFC 8259 (no comments, no trailing commas)"
    )]
    Syntax { problem: String },
    /// Another document of this project.
    #[error(
        "this is a trueaxis {kind}, not {}; give the path of the {}.json instead",
        expected.noun,
        expected.kind()
    )]
    OtherDocument {
        /// Which one, such as `calibration`.
        kind: String,
        expected: Format,
    },
    /// Some other JSON.
    #[error("found {found}; expected \"{}\": is this the right file?", expected.name)]
    Format {
        /// The value of `format` as JSON.
        found: String,
        expected: Format,
    },
    /// A version of the format that this release does not know.
    #[error(
        "found {found}; expected {expected}: a higher version needs a newer release of trueaxis"
    )]
    Version {
        /// The value of `version` as JSON.
        found: String,
        expected: u32,
    },
    /// A field that the format does not have.
    #[error("unknown field `{name}`; {alternatives}")]
    UnknownField {
        name: String,
        alternatives: Alternatives,
    },
    /// A field that must be there.
    #[error("field `{name}` is missing; add it")]
    MissingField { name: String },
    /// A value that cannot be.
    #[error("{found}; expected {expected}")]
    Value { found: String, expected: String },
    /// A name that nothing has.
    #[error("unknown {what} `{name}`; {alternatives}")]
    UnknownName {
        /// What it should name, such as `axis`.
        what: &'static str,
        name: String,
        alternatives: Alternatives,
    },
    /// Two things of one kind share a name.
    #[error("{what} `{name}` has this name already in {first}; give each its own")]
    DuplicateName {
        /// What they are, such as `target`.
        what: &'static str,
        name: String,
        first: String,
    },
}

impl DocumentProblem {
    /// A [`DocumentProblem::Value`].
    pub fn value(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Value {
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// A [`DocumentProblem::MissingField`].
    pub fn missing(name: &str) -> Self {
        let name = name.to_owned();
        Self::MissingField { name }
    }

    /// A [`DocumentProblem::UnknownName`] of something of the kind `what`, of which these names are known.
    pub fn unknown_name<S: AsRef<str>>(
        what: &'static str,
        name: &str,
        known: impl IntoIterator<Item = S>,
    ) -> Self {
        Self::UnknownName {
            what,
            name: name.to_owned(),
            alternatives: Alternatives::new(name, known),
        }
    }

    /// The error with this problem in a field of a document.
    pub fn in_field(self, path: impl Into<String>) -> DocumentError {
        DocumentError {
            place: Place::in_field(path),
            problem: self,
        }
    }
}
