//! Reading a scenario from text, with the line of whatever is wrong.

use std::fs;
use std::path::Path;

use serde::Deserialize;
use trueaxis_campaign::Alternatives;

use crate::field_line::field_line;
use crate::plan::Plan;
use crate::{Error, Place, Scenario};

impl Scenario {
    /// Reads and checks a scenario file.
    ///
    /// # Errors
    /// [`Error::Read`], or [`Error::At`] with file, line and reason.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
        parse(&text, Some(path))
    }

    /// Reads and checks the text of a scenario.
    ///
    /// # Errors
    /// [`Error::At`] with line and reason.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        parse(text, None)
    }
}

fn parse(text: &str, file: Option<&Path>) -> Result<Scenario, Error> {
    let at = |line, source| Error::At {
        place: Place {
            file: file.map(Path::to_owned),
            line,
        },
        source: Box::new(source),
    };
    let header: Header =
        serde_json::from_str(text).map_err(|error| at(error.line(), json_error(".", &error)))?;
    if header.format != Scenario::FORMAT {
        let line = field_line(text, "format");
        let found = header.format;
        return Err(at(line, Error::Format { found }));
    }
    let json = &mut serde_json::Deserializer::from_str(text);
    let scenario: Scenario = serde_path_to_error::deserialize(json).map_err(|error| {
        let source = json_error(&error.path().to_string(), error.inner());
        at(error.inner().line(), source)
    })?;
    Plan::new(&scenario).map_err(|error| {
        let line = error.field().map_or(1, |field| field_line(text, field));
        at(line, error)
    })?;
    Ok(scenario)
}

/// Read first: a file of another format is called that, not blamed for its unknown fields.
#[derive(Deserialize)]
#[serde(expecting = "a scenario in braces")]
struct Header {
    #[serde(default)]
    format: String,
}

/// The parser's message without its place, and what an unknown field may have meant.
///
/// serde writes ``unknown field `a`, expected one of `b`, `c` ``.
fn json_error(path: &str, error: &serde_json::Error) -> Error {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    let message = message.strip_suffix(&place).unwrap_or(&message);
    let nearest = message.starts_with("unknown").then(|| {
        let mut quoted = message.split('`').skip(1).step_by(2);
        let found = quoted.next().unwrap_or_default();
        Alternatives::new(found, quoted).nearest
    });
    Error::Json {
        field: (path != ".").then(|| path.to_owned()),
        message: message.to_owned(),
        nearest: nearest.flatten(),
    }
}
