//! Finds the line of a field in JSON text, so that an error can name it.

/// The line, from 1, on which the value of the field at `path` begins (`runs[1].axis`).
///
/// Where a part of the path is not there (a default applies), it is the line of what should hold
/// it. The text must be valid JSON; a path is followed to the first match of each key.
pub fn field_line(json: &str, path: &str) -> usize {
    let mut cursor = Cursor {
        json: json.as_bytes(),
        at: 0,
    };
    cursor.skip_space();
    for segment in segments(path) {
        let start = cursor.at;
        let found = match segment {
            Segment::Key(key) => cursor.enter_key(key),
            Segment::Index(index) => cursor.enter_index(index),
        };
        if found.is_none() {
            cursor.at = start;
            break;
        }
    }
    let before = cursor.json.iter().take(cursor.at);
    1 + before.filter(|&&byte| byte == b'\n').count()
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

/// A place in valid JSON text. Its methods return `None` at the end of the text, or where
/// something else stands than they look for.
struct Cursor<'a> {
    json: &'a [u8],
    at: usize,
}

impl Cursor<'_> {
    /// From an object to its value of that key.
    fn enter_key(&mut self, key: &str) -> Option<()> {
        self.expect(b'{')?;
        while self.peek()? == b'"' {
            let start = self.at + 1;
            self.skip_string()?;
            let found = self.json.get(start..self.at - 1)?;
            self.skip_space();
            self.expect(b':')?;
            if found == key.as_bytes() {
                return Some(());
            }
            self.skip_value()?;
            self.expect(b',')?;
        }
        None
    }

    /// From a list to its element of that index.
    fn enter_index(&mut self, index: usize) -> Option<()> {
        self.expect(b'[')?;
        for _ in 0..index {
            self.skip_value()?;
            self.expect(b',')?;
        }
        (self.peek()? != b']').then_some(())
    }

    /// To the separator behind the value.
    fn skip_value(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            match self.peek()? {
                b'"' => {
                    self.skip_string()?;
                    continue;
                }
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth > 0 => depth -= 1,
                b',' | b'}' | b']' if depth == 0 => return Some(()),
                _ => {}
            }
            self.at += 1;
        }
    }

    fn skip_string(&mut self) -> Option<()> {
        self.at += 1;
        loop {
            match self.peek()? {
                b'"' => break,
                b'\\' => self.at += 2,
                _ => self.at += 1,
            }
        }
        self.at += 1;
        Some(())
    }

    fn expect(&mut self, byte: u8) -> Option<()> {
        (self.peek()? == byte).then(|| self.at += 1)?;
        self.skip_space();
        Some(())
    }

    fn skip_space(&mut self) {
        while self.peek().is_some_and(|byte| byte.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    fn peek(&self) -> Option<u8> {
        self.json.get(self.at).copied()
    }
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
    fn stops_at_what_should_hold_the_field() {
        assert_eq!(field_line(TEXT, "runs[0].axis"), 1);
        assert_eq!(field_line(TEXT, "targets[1].mounting_error_mm"), 5);
        assert_eq!(field_line(TEXT, "errors.X.components.EYX[3]"), 11);
    }
}
