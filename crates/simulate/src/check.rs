//! Checks of scenario values that name the field.

use trueaxis_campaign::Alternatives;

use crate::Error;

pub(crate) fn expected(field: impl Into<String>, expected: impl Into<String>) -> Error {
    Error::Expected {
        field: field.into(),
        expected: expected.into(),
    }
}

pub(crate) fn finite(field: &str, values: &[f64]) -> Result<(), Error> {
    value(field, values, |v| v.is_finite(), "a finite number")
}

pub(crate) fn not_negative(field: &str, number: f64) -> Result<(), Error> {
    value(field, &[number], |v| v >= 0.0, "zero or more")?;
    finite(field, &[number])
}

pub(crate) fn positive(field: &str, number: f64) -> Result<(), Error> {
    value(field, &[number], |v| v > 0.0, "more than zero")?;
    finite(field, &[number])
}

fn value(
    field: &str,
    values: &[f64],
    good: impl Fn(f64) -> bool,
    expected: &'static str,
) -> Result<(), Error> {
    match values.iter().find(|&&v| !good(v)) {
        None => Ok(()),
        Some(&value) => Err(Error::Value {
            field: field.to_owned(),
            value,
            expected,
        }),
    }
}

/// Finite and strictly increasing.
pub(crate) fn increasing(field: &str, values: &[f64]) -> Result<(), Error> {
    finite(field, values)?;
    let pairs = values.iter().zip(values.iter().skip(1));
    for (i, (&before, &after)) in pairs.enumerate() {
        if after <= before {
            return Err(Error::NotIncreasing {
                field: format!("{field}[{}]", i + 1),
                before,
                after,
            });
        }
    }
    Ok(())
}

/// At least one, none empty, none twice; `list` is the path of the list that holds the names.
pub(crate) fn distinct_names(
    list: &'static str,
    what: &'static str,
    names: &[&str],
) -> Result<(), Error> {
    if names.is_empty() {
        return Err(expected(list, format!("at least one {what}")));
    }
    for (i, &name) in names.iter().enumerate() {
        let field = || format!("{list}[{i}].name");
        if name.trim().is_empty() {
            return Err(expected(field(), "a name"));
        }
        if names.iter().take(i).any(|&other| other == name) {
            return Err(Error::DuplicateName {
                field: field(),
                what,
                name: name.to_owned(),
            });
        }
    }
    Ok(())
}

/// Index of `name` among the known names.
pub(crate) fn index_of(
    field: impl Into<String>,
    what: &'static str,
    name: &str,
    known: &[&str],
) -> Result<usize, Error> {
    known
        .iter()
        .position(|&other| other == name)
        .ok_or_else(|| unknown_name(field, what, name, known))
}

pub(crate) fn unknown_name(
    field: impl Into<String>,
    what: &'static str,
    name: &str,
    known: &[&str],
) -> Error {
    Error::UnknownName {
        field: field.into(),
        what,
        name: name.to_owned(),
        nearest: Alternatives::new(name, known).nearest,
        known: known.join(", "),
    }
}
