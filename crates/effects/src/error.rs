//! What can be wrong with given effects.

use trueaxis_files::{DocumentProblem, Located, OfDocument, Place};

/// Effects that cannot be read, or that cannot happen to the measurement at hand.
///
/// Its message says where: the path of the field, such as `effects[1].parameters[0].unit`; that of an effect that stands
/// alone begins with its own fields.
pub type Error = Located<Problem>;

/// What can be wrong with effects. An [`Error`] says where it is.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Problem {
    /// Of the document, or a name in it.
    #[error(transparent)]
    Document(DocumentProblem),
    /// An effect on something that it does not happen to.
    #[error("{effect} cannot act on ({found}); possible here: {possible}")]
    Subject {
        effect: &'static str,
        found: String,
        possible: String,
    },
    /// A parameter that is not there.
    #[error("{effect} also needs `{name}` in {unit}")]
    MissingParameter {
        effect: &'static str,
        name: String,
        unit: &'static str,
    },
    /// A parameter that is there twice; the field is the second one.
    #[error("there is another parameter named `{name}`")]
    DuplicateParameter { name: String },
    /// A parameter in another unit than its own.
    #[error("`{name}` is in `{expected}`, found `{found}`")]
    Unit {
        name: String,
        expected: &'static str,
        found: String,
    },
    /// A number that is not possible here.
    #[error("expected {expected}, found {value}")]
    Value { value: f64, expected: &'static str },
    /// A covariance that does not have a row and a column for each linear parameter.
    #[error("expected {expected}, one for each linear parameter, found {found}")]
    CovarianceSize { expected: usize, found: usize },
    /// A covariance that is not symmetric.
    #[error(
        "a covariance must be symmetric, but {value} is mirrored by {mirrored} in row {column}"
    )]
    CovarianceAsymmetric {
        /// Column of the element, from 0.
        column: usize,
        value: f64,
        mirrored: f64,
    },
}

impl OfDocument for Problem {
    fn of_document(problem: DocumentProblem) -> Self {
        Self::Document(problem)
    }
}

impl Problem {
    /// The error with this problem in a field.
    pub(crate) fn at(self, field: impl Into<String>) -> Error {
        Error {
            place: Place::in_field(field),
            problem: self,
        }
    }
}
