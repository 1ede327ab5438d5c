//! Names that nothing has: which known one was probably meant.

use trueaxis_files::Alternatives;

use crate::error::{Error, Problem};

/// The index of a name among the known ones, or what was probably meant.
pub(crate) fn index_of(
    field: impl Into<String>,
    what: impl Into<String>,
    name: &str,
    known: &[&str],
) -> Result<usize, Error> {
    let unknown = || Problem::UnknownName {
        what: what.into(),
        name: name.to_owned(),
        known: Alternatives::new(name, known),
    };
    let found = known.iter().position(|&other| other == name);
    found.ok_or_else(|| unknown().at(field))
}
