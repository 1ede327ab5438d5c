//! Finds a field in JSON text, so that an error can name its line and point at it.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::value::RawValue;

/// The line, from 1, on which the value of the field at `path` begins (`runs[1].axis`).
///
/// Where a part of the path is not there (a default applies), it is the line of what should hold
/// it. The text must be valid JSON.
pub fn field_line(json: &str, path: &str) -> usize {
    let (value, _) = walk(json, path);
    1 + json[..value.start].matches('\n').count()
}

/// The bytes of a field with its key, or of an element of a list; none where it is not there.
///
/// The text must be valid JSON.
pub fn field_span(json: &str, path: &str) -> Option<Range<usize>> {
    let (value, is_whole) = walk(json, path);
    let key = match segments(path).last()? {
        Segment::Key(key) => json[..value.start].rfind(&format!("\"{key}\"")),
        Segment::Index(_) => None,
    };
    is_whole.then(|| key.unwrap_or(value.start)..value.end)
}

/// The bytes of the value as far as the path leads, and whether that is to its end.
fn walk(json: &str, path: &str) -> (Range<usize>, bool) {
    let begin = json.len() - json.trim_start().len();
    let mut value = begin..json.trim_end().len();
    for segment in segments(path) {
        let text = &json[value.clone()];
        let inner = match segment {
            Segment::Key(key) => serde_json::from_str(text)
                .ok()
                .and_then(|mut fields: BTreeMap<String, &RawValue>| fields.remove(key)),
            Segment::Index(index) => serde_json::from_str(text)
                .ok()
                .and_then(|elements: Vec<&RawValue>| elements.get(index).copied()),
        };
        let Some(inner) = inner.map(RawValue::get) else {
            return (value, false);
        };
        // It is borrowed from the text.
        let start = inner.as_ptr().addr() - json.as_ptr().addr();
        value = start..start + inner.len();
    }
    (value, true)
}

enum Segment<'a> {
    Key(&'a str),
    Index(usize),
}

/// `runs[1].axis` is the key `runs`, the index 1, the key `axis`.
fn segments(path: &str) -> impl Iterator<Item = Segment<'_>> {
    path.split(['.', '['])
        .map(|part| match part.strip_suffix(']').map(str::parse) {
            Some(Ok(index)) => Segment::Index(index),
            _ => Segment::Key(part),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{
  "name": "a \"quoted\" } name",
  "targets": [
    { "name": "P", "position_mm": [1, 2, 3] },
    { "name": "Q",
      "position_mm": [4,
                      5, 6] }
  ],
  "errors": { "X": { "components": {
    "EXX": [ { "kind": "sine" } ],
    "EYX": []
  } } }
}"#;

    #[test]
    fn finds_fields_at_every_depth() {
        let cases = [
            ("name", 2),
            ("targets", 3),
            ("targets[0].position_mm[2]", 4),
            ("targets[1].name", 5),
            ("targets[1].position_mm[1]", 7),
            ("errors.X.components.EXX[0].kind", 10),
            ("errors.X.components.EYX", 11),
        ];
        for (path, line) in cases {
            assert_eq!(field_line(TEXT, path), line, "{path}");
        }
    }

    #[test]
    fn spans_hold_key_and_value() {
        for (path, text) in [
            ("targets[0].name", Some("\"name\": \"P\"")),
            ("targets[0].position_mm[1]", Some("2")),
            ("errors.X.components.EYX", Some("\"EYX\": []")),
            ("targets[2].name", None),
        ] {
            assert_eq!(
                field_span(TEXT, path).map(|span| &TEXT[span]),
                text,
                "{path}"
            );
        }
    }

    #[test]
    fn stops_at_what_should_hold_the_field() {
        assert_eq!(field_line(TEXT, "runs[0].axis"), 1);
        assert_eq!(field_line(TEXT, "targets[1].mounting_error_mm"), 5);
        assert_eq!(field_line(TEXT, "errors.X.components.EYX[3]"), 11);
    }
}
