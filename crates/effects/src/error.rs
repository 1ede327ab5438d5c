//! What can be wrong with given effects.

use trueaxis_files::{Alternatives, DocumentError};

/// Effects that cannot be read, or that cannot happen to the measurement at hand.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The text is not JSON, or no effects file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A field that is wrong.
    #[error("{field}: {problem}")]
    Field {
        /// Its path, such as `effects[1].parameters[0].unit`; that of an effect that stands alone begins with
        /// its own fields.
        field: String,
        /// What is wrong.
        problem: Problem,
    },
}

/// What is wrong with a field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// A name that nothing has.
    #[error("no {what} is named `{name}` (known: {}){}", known.known.join(", "), did_you_mean(known))]
    UnknownName {
        /// What the name should stand for.
        what: String,
        /// The name.
        name: String,
        /// The known names.
        known: Alternatives,
    },
    /// An effect on something that it does not happen to.
    #[error("{effect} cannot act on ({found}); possible here: {possible}")]
    Subject {
        /// Name of the effect.
        effect: &'static str,
        /// The subject.
        found: String,
        /// Those that the effect can happen to.
        possible: String,
    },
    /// A parameter that is not there.
    #[error("{effect} also needs `{name}` in {unit}")]
    MissingParameter {
        /// Name of the effect.
        effect: &'static str,
        /// Name of the parameter.
        name: String,
        /// Its unit.
        unit: &'static str,
    },
    /// A parameter that is there twice; the field is the second one.
    #[error("there is another parameter named `{name}`")]
    DuplicateParameter {
        /// Its name.
        name: String,
    },
    /// A parameter in another unit than its own.
    #[error("`{name}` is in `{expected}`, found `{found}`")]
    Unit {
        /// Name of the parameter.
        name: String,
        /// Its unit.
        expected: &'static str,
        /// The unit in the file.
        found: String,
    },
    /// A number that is not possible here.
    #[error("expected {expected}, found {value}")]
    Value {
        /// The number.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// A covariance that does not have a row and a column for each linear parameter.
    #[error("expected {expected}, one for each linear parameter, found {found}")]
    CovarianceSize {
        /// Number of linear parameters of all effects.
        expected: usize,
        /// Number of rows, or of values in the row.
        found: usize,
    },
    /// A covariance that is not symmetric.
    #[error(
        "a covariance must be symmetric, but {value} is mirrored by {mirrored} in row {column}"
    )]
    CovarianceAsymmetric {
        /// Column of the element, from 0.
        column: usize,
        /// The element.
        value: f64,
        /// The one on the other side of the diagonal.
        mirrored: f64,
    },
}

impl Error {
    /// Path of the field that is wrong, where it is one field.
    pub fn field(&self) -> Option<&str> {
        match self {
            Self::Document(error) => error.place.field_path(),
            Self::Field { field, .. } => Some(field),
        }
    }

    /// The same error where its field is a part of `outer`.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        if let Self::Field { field, .. } = &mut self {
            *field = format!("{outer}.{field}");
        }
        self
    }
}

impl Problem {
    /// The error that this is in a field.
    pub(crate) fn at(self, field: impl Into<String>) -> Error {
        Error::Field {
            field: field.into(),
            problem: self,
        }
    }
}

fn did_you_mean(known: &Alternatives) -> String {
    let nearest = known.nearest.as_ref();
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
