//! What can be wrong with given effects.

use trueaxis_files::{Alternatives, DocumentError};

/// Effects that cannot be read, or that cannot happen to the measurement at hand.
///
/// `field` is the path of the field, as `effects[1].parameters[0].unit`; that of an effect that stands
/// alone begins with its own fields.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The text is not JSON, or no effects file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A name that nothing has.
    #[error("{field}: no {what} is named `{name}` (known: {known}){}", did_you_mean(nearest.as_deref()))]
    UnknownName {
        /// Path of the field.
        field: String,
        /// What the name should stand for.
        what: String,
        /// The name.
        name: String,
        /// The known name closest to it.
        nearest: Option<String>,
        /// All known names.
        known: String,
    },
    /// An effect on something that it does not happen to.
    #[error("{field}: {effect} cannot happen to ({found}); possible here: {possible}")]
    Subject {
        /// Path of the subject.
        field: String,
        /// Name of the effect.
        effect: &'static str,
        /// The subject.
        found: String,
        /// Those that the effect can happen to.
        possible: String,
    },
    /// A parameter that is not there.
    #[error("{field}: {effect} also needs `{name}` in {unit}")]
    MissingParameter {
        /// Path of the parameters.
        field: String,
        /// Name of the effect.
        effect: &'static str,
        /// Name of the parameter.
        name: String,
        /// Its unit.
        unit: &'static str,
    },
    /// A parameter that is there twice.
    #[error("{field}: there is another parameter named `{name}`")]
    DuplicateParameter {
        /// Path of the second one.
        field: String,
        /// Its name.
        name: String,
    },
    /// A parameter in another unit than its own.
    #[error("{field}: `{name}` is in `{expected}`, found `{found}`")]
    Unit {
        /// Path of the unit.
        field: String,
        /// Name of the parameter.
        name: String,
        /// Its unit.
        expected: &'static str,
        /// The unit in the file.
        found: String,
    },
    /// A number that is not possible here.
    #[error("{field}: expected {expected}, found {value}")]
    Value {
        /// Path of the number.
        field: String,
        /// The number.
        value: f64,
        /// What is possible.
        expected: &'static str,
    },
    /// A covariance that does not have a row and a column for each linear parameter.
    #[error("{field}: expected {expected}, one for each linear parameter, found {found}")]
    CovarianceSize {
        /// Path of the matrix or the row.
        field: String,
        /// Number of linear parameters of all effects.
        expected: usize,
        /// Number of rows, or of values in the row.
        found: usize,
    },
    /// A covariance that is not symmetric.
    #[error(
        "{field}: a covariance is symmetric, but {value} is mirrored by {mirrored} in row {column}"
    )]
    CovarianceAsymmetric {
        /// Path of the element.
        field: String,
        /// Its column, from 0.
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
            Self::UnknownName { field, .. }
            | Self::Subject { field, .. }
            | Self::MissingParameter { field, .. }
            | Self::DuplicateParameter { field, .. }
            | Self::Unit { field, .. }
            | Self::Value { field, .. }
            | Self::CovarianceSize { field, .. }
            | Self::CovarianceAsymmetric { field, .. } => Some(field),
        }
    }

    /// The same error where its field is a part of `outer`.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        match &mut self {
            Self::Document(_) => {}
            Self::UnknownName { field, .. }
            | Self::Subject { field, .. }
            | Self::MissingParameter { field, .. }
            | Self::DuplicateParameter { field, .. }
            | Self::Unit { field, .. }
            | Self::Value { field, .. }
            | Self::CovarianceSize { field, .. }
            | Self::CovarianceAsymmetric { field, .. } => *field = format!("{outer}.{field}"),
        }
        self
    }
}

/// The index of a name among the known ones, or what was probably meant.
pub(crate) fn index_of(
    field: impl Into<String>,
    what: impl Into<String>,
    name: &str,
    known: &[&str],
) -> Result<usize, Error> {
    let found = known.iter().position(|&other| other == name);
    found.ok_or_else(|| Error::UnknownName {
        field: field.into(),
        what: what.into(),
        name: name.to_owned(),
        nearest: Alternatives::new(name, known).nearest,
        known: known.join(", "),
    })
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}
