//! The names in a document: each its own, and found by name.

use crate::{DocumentError, DocumentProblem};

/// Checks that `name`, which stands in `field`, is one. Cells of tables are read without the blanks around them, so it
/// must not have any.
///
/// # Errors
/// [`DocumentProblem::Value`], with the field.
pub fn check_name(field: &str, name: &str) -> Result<(), DocumentError> {
    if name.is_empty() || name.trim() != name {
        let found = format!("name \"{name}\"");
        let problem = DocumentProblem::value(found, "a name, without blanks around it");
        return Err(problem.in_field(field));
    }
    Ok(())
}

/// Checks names, and that they can be distinguished; `list` is the path of their list, such as `targets`, and `what` the
/// kind in the singular.
///
/// # Errors
/// [`DocumentProblem::Value`] and [`DocumentProblem::DuplicateName`], with the field.
pub fn check_names(list: &str, what: &'static str, names: &[&str]) -> Result<(), DocumentError> {
    for (i, name) in names.iter().enumerate() {
        let path = format!("{list}[{i}].name");
        check_name(&path, name)?;
        if let Some(first) = names[..i].iter().position(|other| other == name) {
            let problem = DocumentProblem::DuplicateName {
                what,
                name: (*name).to_owned(),
                first: format!("{list}[{first}].name"),
            };
            return Err(problem.in_field(path));
        }
    }
    Ok(())
}

/// Index of `name`, which stands in `field`, among the known names.
///
/// # Errors
/// [`DocumentProblem::UnknownName`], with the field.
pub fn index_of(
    field: impl Into<String>,
    what: &'static str,
    name: &str,
    known: &[&str],
) -> Result<usize, DocumentError> {
    let found = known.iter().position(|&other| other == name);
    found.ok_or_else(|| {
        let problem = DocumentProblem::unknown_name(what, name, known);
        problem.in_field(field)
    })
}
