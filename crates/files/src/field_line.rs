//! Finds a field in JSON text, so that an error can name its line and point at it, and the field at a place.

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

/// The path of the field that a reader of the text was at when it had read so many bytes; empty for the
/// document itself.
///
/// That is the field read last, or the one that begins there with a bracket which the reader refused. A field
/// unknown ends with its key, an object or a list with its bracket.
pub(crate) fn field_at(json: &str, read: usize) -> String {
    let rest = json.get(read..).unwrap_or_default().trim_start();
    let end = match rest.starts_with(['{', '[']) {
        true => json.len() - rest.len() + 1,
        false => json.get(..read).unwrap_or(json).trim_end().len(),
    };
    let bytes = &json.as_bytes()[..end];
    let mut path: Vec<Segment<'_>> = Vec::new();
    let mut at = 0;
    let mut is_key = false;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'"' => {
                let start = at + 1;
                at = start;
                while !matches!(bytes.get(at), Some(b'"') | None) {
                    at += 1 + usize::from(bytes[at] == b'\\');
                }
                if let (true, Some(Segment::Key(key))) = (is_key, path.last_mut()) {
                    *key = json.get(start..at).unwrap_or_default();
                    is_key = false;
                }
            }
            b'{' => path.push(Segment::Key("")),
            b'[' => path.push(Segment::Index(0)),
            b'}' | b']' => drop(path.pop()),
            b',' => {
                if let Some(Segment::Index(index)) = path.last_mut() {
                    *index += 1;
                }
            }
            _ => {}
        }
        if matches!(byte, b'{' | b',') {
            is_key = matches!(path.last(), Some(Segment::Key(_)));
        }
        at += 1;
    }
    // What begins here is not read, so that it is what holds it that is meant.
    if matches!(bytes.last(), Some(b'{' | b'[')) {
        path.pop();
    }
    let mut text = String::new();
    for segment in path {
        text += &match segment {
            Segment::Key(key) if text.is_empty() => key.to_owned(),
            Segment::Key(key) => format!(".{key}"),
            Segment::Index(index) => format!("[{index}]"),
        };
    }
    text
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

    /// Where a reader stands: behind a value, a key or a bracket, or before a bracket that it refuses.
    #[test]
    fn fields_are_found_by_their_place() {
        for (behind, path) in [
            ("\"name\": \"P\"", "targets[0].name"),
            ("\"Q\"", "targets[1].name"),
            ("\"position_mm\": [4", "targets[1].position_mm[0]"),
            ("\"position_mm\"", "targets[0].position_mm"),
            ("[1, 2, 3]", "targets[0].position_mm"),
            ("[1, 2, 3] }", "targets[0]"),
            ("\"targets\": ", "targets"),
            ("\"EXX\": [", "errors.X.components.EXX[0]"),
            ("\"sine\"", "errors.X.components.EXX[0].kind"),
            ("} } }\n}", ""),
        ] {
            let read = TEXT.find(behind).unwrap() + behind.len();
            assert_eq!(field_at(TEXT, read), path, "{behind}");
        }
    }

    #[test]
    fn stops_at_what_should_hold_the_field() {
        assert_eq!(field_line(TEXT, "runs[0].axis"), 1);
        assert_eq!(field_line(TEXT, "targets[1].mounting_error_mm"), 5);
        assert_eq!(field_line(TEXT, "errors.X.components.EYX[3]"), 11);
    }
}
