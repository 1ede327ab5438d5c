//! Checks of scenario values that name the field.

use trueaxis_files::check_names;

use crate::{Error, Problem};

pub(crate) fn expected(field: impl Into<String>, expected: impl Into<String>) -> Error {
    let expected = expected.into();
    Problem::Expected { expected }.at(field)
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

/// A standard deviation of the scenario's part `part`, else what the instrument declares of that name, else none.
pub(crate) fn sigma(
    part: &str,
    name: &str,
    own: Option<f64>,
    declared: Option<f64>,
) -> Result<f64, Error> {
    let part = if own.is_some() { part } else { "instrument" };
    let sigma = own.or(declared).unwrap_or(0.0);
    not_negative(&format!("{part}.{name}"), sigma).map(|()| sigma)
}

fn value(
    field: &str,
    values: &[f64],
    good: impl Fn(f64) -> bool,
    expected: &'static str,
) -> Result<(), Error> {
    match values.iter().find(|&&v| !good(v)) {
        None => Ok(()),
        Some(&value) => Err(Problem::Value { value, expected }.at(field)),
    }
}

/// Finite and strictly increasing.
pub(crate) fn increasing(field: &str, values: &[f64]) -> Result<(), Error> {
    finite(field, values)?;
    let pairs = values.iter().zip(values.iter().skip(1));
    for (i, (&before, &after)) in pairs.enumerate() {
        if after <= before {
            let field = format!("{field}[{}]", i + 1);
            return Err(Problem::NotIncreasing { before, after }.at(field));
        }
    }
    Ok(())
}

/// As many values as there are increasing places (`what`), one at least; both with the names of their fields.
pub(crate) fn table(
    field: &str,
    what: &str,
    (of_places, places): (&str, &[f64]),
    (of_values, values): (&str, &[f64]),
) -> Result<(), Error> {
    finite(&format!("{field}.{of_values}"), values)?;
    increasing(&format!("{field}.{of_places}"), places)?;
    if places.is_empty() || places.len() != values.len() {
        let (p, v) = (places.len(), values.len());
        let words = format!("as many values as {what}, found {v} and {p}");
        return Err(expected(field, words));
    }
    Ok(())
}

/// At least one, none empty, none twice; `list` is the path of the list that holds the names.
pub(crate) fn distinct_names(list: &str, what: &'static str, names: &[&str]) -> Result<(), Error> {
    if names.is_empty() {
        return Err(expected(list, format!("at least one {what}")));
    }
    Ok(check_names(list, what, names)?)
}
