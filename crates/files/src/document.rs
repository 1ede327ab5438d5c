//! Reading the JSON documents of this project: where something is wrong, and which name was meant.

use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use serde_json::error::Category;

use crate::schema_key::without_schema_key;
use crate::{DocumentError, DocumentProblem, Part, Place, field_line};

/// A format of this project.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Format {
    /// What the field `format` must say, such as `trueaxis-campaign`.
    pub name: &'static str,
    /// What the field `version` must say.
    pub version: u32,
    /// What a document of this format is called, such as `a campaign`.
    pub noun: &'static str,
}

/// All formats begin with this.
const PREFIX: &str = "trueaxis-";

impl Format {
    /// `campaign` of `trueaxis-campaign`.
    pub(crate) fn kind(&self) -> &'static str {
        self.name.strip_prefix(PREFIX).unwrap_or(self.name)
    }

    /// Reads a document of this format; `$schema` at its top is ignored. Format and version come first: a document of another format
    /// or a later version is called that, and not blamed for its unknown fields.
    ///
    /// # Errors
    /// With the line and the field; `file` is only named.
    pub fn read<T: DeserializeOwned>(
        &self,
        text: &str,
        file: Option<&Path>,
    ) -> Result<T, DocumentError> {
        self.check_header(text)
            .and_then(|()| {
                let text = &without_schema_key(text);
                let deserializer = &mut serde_json::Deserializer::from_str(text);
                serde_path_to_error::deserialize(deserializer)
                    .map_err(|error| refused(&error.path().to_string(), error.inner()))
            })
            .map_err(|mut error: DocumentError| {
                error.place.file = file.map(Path::to_owned);
                error
            })
    }

    fn check_header(&self, text: &str) -> Result<(), DocumentError> {
        let header: Header =
            serde_json::from_str(text).map_err(|error| self.not_an_object(&error))?;
        let wrong = |field: &str, problem| {
            let line = field_line(text, field);
            let place = Box::new(Place {
                line: Some(line),
                ..*Place::in_field(field)
            });
            Err(DocumentError { place, problem })
        };
        match header.format {
            Some(Value::String(format)) if format == self.name => {}
            Some(Value::String(format)) if format.starts_with(PREFIX) => {
                let kind = format[PREFIX.len()..].to_owned();
                let expected = *self;
                return wrong("format", DocumentProblem::OtherDocument { kind, expected });
            }
            format => {
                let (found, expected) = (found(format), *self);
                return wrong("format", DocumentProblem::Format { found, expected });
            }
        }
        match header.version {
            Some(version) if version == self.version => Ok(()),
            version => {
                let (found, expected) = (found(version), self.version);
                wrong("version", DocumentProblem::Version { found, expected })
            }
        }
    }

    /// The error for text that is not JSON, or no object.
    fn not_an_object(&self, error: &serde_json::Error) -> DocumentError {
        let message = message(error);
        let is_json = error.classify() == Category::Data;
        let place = Box::new(Place {
            line: Some(error.line()),
            part: (!is_json).then(|| Part::Character(error.column())),
            ..Place::default()
        });
        let problem = match message.split_once(", expected ") {
            Some((found, _)) if is_json => DocumentProblem::Value {
                found: found.to_owned(),
                expected: format!("an object in braces: {}", self.noun),
            },
            // A table, or another text.
            _ if error.line() == 1 && error.column() <= 2 && message.starts_with("expected") => {
                DocumentProblem::Syntax {
                    problem: "it does not begin with a brace: is this the right file?".to_owned(),
                }
            }
            _ if error.is_eof() => DocumentProblem::Syntax {
                problem: "it ends too early: was it saved completely?".to_owned(),
            },
            _ => DocumentProblem::Syntax { problem: message },
        };
        DocumentError { place, problem }
    }
}

#[derive(Deserialize)]
struct Header {
    format: Option<Value>,
    version: Option<Value>,
}

fn found(value: Option<Value>) -> String {
    value.map_or_else(|| "nothing".to_owned(), |value| value.to_string())
}

/// The error for JSON that is not of the form of the document.
fn refused(path: &str, error: &serde_json::Error) -> DocumentError {
    DocumentError {
        place: Box::new(Place {
            line: Some(error.line()),
            part: (path != ".").then(|| Part::Field(path.to_owned())),
            ..Place::default()
        }),
        problem: DocumentProblem::from_serde(&message(error)),
    }
}

/// The message without the position, which the [`Place`] holds.
fn message(error: &serde_json::Error) -> String {
    let position = format!(" at line {} column {}", error.line(), error.column());
    let message = error.to_string();
    let without = message.strip_suffix(&position).unwrap_or(&message);
    without.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMAT: Format = Format {
        name: "trueaxis-campaign",
        version: 1,
        noun: "a campaign",
    };

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[expect(dead_code, reason = "only read")]
    struct Document {
        format: String,
        version: u32,
        kind: Kind,
        travel: Option<[f64; 2]>,
        direction: Option<[f64; 3]>,
        axes: Option<Vec<Document>>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Kind {
        Linear,
        Rotary,
    }

    fn refusal(text: &str) -> DocumentError {
        FORMAT.read::<Document>(text, None).unwrap_err()
    }

    #[test]
    fn another_document_is_named_before_its_fields_are_blamed() {
        let text = r#"{"format": "trueaxis-calibration", "version": 7, "novelty": []}"#;
        assert_eq!(
            refusal(text).to_string(),
            "line 1, field format: this is a trueaxis calibration, not a campaign; give the path \
             of the campaign.json instead"
        );
    }

    #[test]
    fn the_version_comes_before_unknown_fields() {
        let error = refusal(r#"{"format": "trueaxis-campaign", "version": 2, "novelty": 1}"#);
        assert!(matches!(error.problem, DocumentProblem::Version { found, .. } if found == "2"));
    }

    /// The wording of serde is what the errors are made from: this fails if it ever changes.
    #[test]
    fn serde_messages_are_understood() {
        for (rest, expected) in [
            (
                r#""kin": 1"#,
                "line 1, field kin: unknown field `kin`; did you mean `kind`? known: format, \
                 version, kind, travel, direction, axes",
            ),
            (
                r#""kind": "linar""#,
                "line 1, field kind: unknown value `linar`; did you mean `linear`? known: linear, \
                 rotary",
            ),
            (
                r#""direction": [1, 2]"#,
                "line 1, field direction: invalid length 2; expected three numbers: x, y and z",
            ),
            (
                r#""direction": [1, 2, 3, 4]"#,
                "line 1, field direction: the list is too long; expected three coordinates for a \
                 point, two ends for a travel",
            ),
            (
                r#""travel": ["0", 1]"#,
                "line 1, field travel[0]: invalid type: string \"0\"; expected a number with a \
                 decimal point",
            ),
            (
                r#""axes": [{}]"#,
                "line 1, field axes[0]: field `format` is missing; add it",
            ),
            (
                r#""axes": [,]"#,
                "line 1, character 56: not valid JSON: expected value; expected JSON as in RFC \
                 8259 (no comments, no trailing commas)",
            ),
        ] {
            let start = r#"{"format": "trueaxis-campaign", "version": 1, "#;
            assert_eq!(refusal(&format!("{start}{rest}}}")).to_string(), expected);
        }
        for cut in [
            r#"{"format": "trueaxis-camp"#,
            r#"{"format": "trueaxis-campaign", "version": 1"#,
        ] {
            let refused = refusal(cut).to_string();
            assert!(refused.contains("was it saved completely?"), "{refused}");
        }
        for table in ["time_s,station\n", "x,y\n", "# points\n"] {
            let refused = refusal(table).to_string();
            assert!(refused.contains("is this the right file?"), "{refused}");
        }
    }
}
