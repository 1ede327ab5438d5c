//! From the text of `campaign.json` to the [`Document`], with places in every error.

use std::path::Path;

use serde::Deserialize;
use serde_json::Value;
use serde_json::error::Category;

use crate::document::Document;
use crate::{Alternatives, Error, Part, Place};

/// The string in `format`.
pub(crate) const FORMAT: &str = "trueaxis-campaign";

/// The version read and written.
pub(crate) const VERSION: u32 = 1;

/// Other formats of this project share this beginning.
const FORMAT_PREFIX: &str = "trueaxis-";

/// Parses `text`. Format and version come first: a document of another format or a later version
/// is called that, and not blamed for its unknown fields.
pub(crate) fn parse(file: &Path, text: &str) -> Result<Document, Error> {
    check_format(file, text)?;
    let deserializer = &mut serde_json::Deserializer::from_str(text);
    serde_path_to_error::deserialize(deserializer).map_err(|error| {
        let path = error.path().to_string();
        refused(file, &path, error.inner())
    })
}

#[derive(Deserialize)]
#[serde(expecting = "an object in braces: the campaign")]
struct Header {
    format: Option<Value>,
    version: Option<Value>,
}

fn check_format(file: &Path, text: &str) -> Result<(), Error> {
    let header: Header = serde_json::from_str(text).map_err(|error| match error.classify() {
        Category::Data => refused(file, ".", &error),
        _ => Error::Syntax {
            place: Place::line(file, error.line()),
            character: error.column(),
            problem: message(&error),
        },
    })?;
    match header.format {
        Some(Value::String(format)) if format == FORMAT => {}
        Some(Value::String(format)) if format.starts_with(FORMAT_PREFIX) => {
            return Err(Error::OtherDocument {
                place: Place::field(file, "format"),
                kind: format[FORMAT_PREFIX.len()..].to_owned(),
            });
        }
        format => {
            return Err(Error::Format {
                place: Place::field(file, "format"),
                found: found(format),
            });
        }
    }
    match header.version {
        Some(version) if version == VERSION => Ok(()),
        version => Err(Error::Version {
            place: Place::field(file, "version"),
            found: found(version),
        }),
    }
}

fn found(value: Option<Value>) -> String {
    value.map_or_else(|| "nothing".to_owned(), |value| value.to_string())
}

/// The error for a document that is JSON but not a campaign.
fn refused(file: &Path, path: &str, error: &serde_json::Error) -> Error {
    let place = |path: &str| {
        Box::new(Place {
            part: (path != ".").then(|| Part::Field(path.to_owned())),
            ..*Place::line(file, error.line())
        })
    };
    let message = message(error);
    // serde puts the name found first and the names it knows after it, each in backticks.
    let mut names = message.split('`').skip(1).step_by(2);
    let first = names.next().unwrap_or_default();
    if message.starts_with("unknown field") {
        return Error::UnknownField {
            place: place(path),
            name: first.to_owned(),
            alternatives: Alternatives::new(first, names),
        };
    }
    if message.starts_with("unknown variant") {
        return Error::UnknownName {
            place: place(path),
            what: "value",
            name: first.to_owned(),
            alternatives: Alternatives::new(first, names),
        };
    }
    if message.starts_with("missing field") {
        return Error::MissingField {
            place: place(path),
            name: first.to_owned(),
        };
    }
    // The syntax has been checked before, so this is how the parser sees an entry too many.
    if message == "trailing characters" {
        return Error::Value {
            place: place(path),
            found: "the list is too long".to_owned(),
            expected: "three coordinates for a point, two ends for a travel".to_owned(),
        };
    }
    let (found, expected) = message
        .split_once(", expected ")
        .unwrap_or((&message, "the form that the format describes"));
    Error::Value {
        place: place(path),
        found: found.to_owned(),
        expected: in_words(expected),
    }
}

/// The message without the position, which the [`Place`] holds.
fn message(error: &serde_json::Error) -> String {
    let position = format!(" at line {} column {}", error.line(), error.column());
    let message = error.to_string();
    message
        .strip_suffix(&position)
        .map_or(message.clone(), str::to_owned)
}

/// Names of Rust types in words of the user.
fn in_words(expected: &str) -> String {
    match expected {
        "f64" => "a number with a decimal point",
        "a sequence" => "a list in square brackets",
        "an array of length 2" => "two numbers: the low and the high end",
        "an array of length 3" => "three numbers: x, y and z",
        other => other,
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> Error {
        parse(Path::new("campaign.json"), text).unwrap_err()
    }

    #[test]
    fn another_document_is_named_before_its_fields_are_blamed() {
        let error = refusal(r#"{"format": "trueaxis-calibration", "version": 7, "axes": []}"#);
        assert!(matches!(error, Error::OtherDocument { kind, .. } if kind == "calibration"));
    }

    #[test]
    fn the_version_comes_before_unknown_fields() {
        let error = refusal(r#"{"format": "trueaxis-campaign", "version": 2, "novelty": 1}"#);
        assert!(matches!(error, Error::Version { found, .. } if found == "2"));
    }

    /// The wording of serde is what the errors are made from: this fails if it ever changes.
    #[test]
    fn serde_messages_are_understood() {
        let start = r#"{"format": "trueaxis-campaign", "version": 1, "name": "n", "#;
        let refusal = |rest: &str| refusal(&format!("{start}{rest}")).to_string();
        let machine = |axis: &str| {
            refusal(&format!(
                r#""machine": {{"name": "", "kinematics": {{"tool": [], "workpiece": []}}, "axes": [{axis}]}}}}"#
            ))
        };
        assert_eq!(
            refusal(r#""machin": {}}"#),
            "campaign.json line 1, field machin: unknown field `machin`; did you mean `machine`? \
             known: format, version, name, machine, instrument, targets, stations, runs, lengths, \
             points, verification"
        );
        assert_eq!(
            machine(r#"{"name": "X", "kind": "linar"}"#),
            "campaign.json line 1, field machine.axes[0].kind: unknown value `linar`; did you \
             mean `linear`? known: linear, rotary"
        );
        assert_eq!(
            machine(r#"{"name": "X", "direction": [1, 2]}"#),
            "campaign.json line 1, field machine.axes[0].direction: invalid length 2; expected \
             three numbers: x, y and z"
        );
        assert_eq!(
            machine(r#"{"name": "X", "direction": [1, 2, 3, 4]}"#),
            "campaign.json line 1, field machine.axes[0].direction: the list is too long; \
             expected three coordinates for a point, two ends for a travel"
        );
        assert_eq!(
            machine(r#"{"name": "X", "travel": ["0", 1]}"#),
            "campaign.json line 1, field machine.axes[0].travel[0]: invalid type: string \"0\"; \
             expected a number with a decimal point"
        );
        assert_eq!(
            machine(r#"{"name": "X"}"#),
            "campaign.json line 1, field machine.axes[0]: field `kind` is missing; add it"
        );
    }
}
