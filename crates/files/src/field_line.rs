//! Finds a field in JSON text, so that an error can name its line and point at it.

use std::ops::Range;

use crate::cursor::Cursor;

/// The line, from 1, on which the value of the field at `path` begins (`runs[1].axis`).
///
/// Where a part of the path is not there (a default applies), it is the line of what should hold
/// it. The text must be valid JSON; a path is followed to the first match of each key.
pub fn field_line(json: &str, path: &str) -> usize {
    let (cursor, _) = walk(json, path);
    let before = json.bytes().take(cursor.at);
    1 + before.filter(|&byte| byte == b'\n').count()
}

/// The bytes of a field with its key, or of an element of a list; none where it is not there.
///
/// The text must be valid JSON.
pub fn field_span(json: &str, path: &str) -> Option<Range<usize>> {
    let (mut cursor, is_there) = walk(json, path);
    let begin = cursor.begin;
    cursor.skip_value()?;
    let text = json.get(begin..cursor.at)?.trim_end();
    is_there.then_some(begin..begin + text.len())
}

/// As far as the path leads, and whether that is to its end.
fn walk<'j>(json: &'j str, path: &str) -> (Cursor<'j>, bool) {
    let mut cursor = Cursor::new(json);
    for segment in segments(path) {
        let (start, begin) = (cursor.at, cursor.begin);
        let found = match segment {
            Segment::Key(key) => cursor.enter_key(key),
            Segment::Index(index) => cursor.enter_index(index),
        };
        if found.is_none() {
            (cursor.at, cursor.begin) = (start, begin);
            return (cursor, false);
        }
    }
    (cursor, true)
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
