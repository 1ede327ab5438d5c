//! What serde says, in the user's words.

use crate::{Alternatives, DocumentProblem};

/// How the parser sees an entry too many in a list of fixed length; the syntax has been checked before.
const TRAILING: &str = "trailing characters";

impl DocumentProblem {
    /// What serde says of a document (JSON, TOML), without its position. serde gives its reasons as text alone: the
    /// kind first, then the name found and those that it knows, each in backticks.
    pub fn from_serde(message: &str) -> Self {
        let mut names = message.split('`').skip(1).step_by(2);
        let name = names.next().unwrap_or_default().to_owned();
        if message.starts_with("unknown field") {
            let alternatives = Alternatives::new(&name, names);
            return Self::UnknownField { name, alternatives };
        }
        if message.starts_with("unknown variant") {
            return Self::UnknownName {
                what: "value",
                alternatives: Alternatives::new(&name, names),
                name,
            };
        }
        if message.starts_with("missing field") {
            return Self::MissingField { name };
        }
        let (found, expected) = match message {
            TRAILING => (
                "the list is too long",
                "three coordinates for a point, two ends for a travel",
            ),
            _ => message
                .split_once(", expected ")
                .unwrap_or((message, "the form that the format describes")),
        };
        Self::Value {
            found: found.to_owned(),
            expected: in_words(expected).to_owned(),
        }
    }
}

/// Names of Rust types in the user's words.
fn in_words(expected: &str) -> &str {
    match expected {
        "f64" => "a number with a decimal point",
        "a sequence" => "a list in square brackets",
        "an array of length 2" => "two numbers: the low and the high end",
        "an array of length 3" => "three numbers: x, y and z",
        other => other,
    }
}
