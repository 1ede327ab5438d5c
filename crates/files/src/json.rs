//! JSON with a line for each field.

use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::Formatter;
use serde_json::{Serializer, Value};

/// Spaces for each level of nesting.
const INDENT: usize = 2;

/// `value` as JSON: objects over several lines, arrays on one line (objects in them again over
/// several), a newline at the end.
///
/// # Errors
/// If `value` cannot be serialised, such as a map whose keys are not strings.
pub fn to_json(value: &impl Serialize) -> serde_json::Result<String> {
    let mut bytes = Vec::new();
    let formatter = FieldPerLine {
        depth: 0,
        empty: true,
    };
    value.serialize(&mut Serializer::with_formatter(&mut bytes, formatter))?;
    bytes.push(b'\n');
    String::from_utf8(bytes).map_err(serde::ser::Error::custom)
}

/// [`to_json`] of a value, which has no way to fail.
pub fn value_to_json(value: &Value) -> String {
    to_json(value).expect("numbers and strings serialise")
}

/// An object without its fields that are null: the optional ones that do not apply.
pub fn without_nulls(mut object: Value) -> Value {
    if let Value::Object(fields) = &mut object {
        fields.retain(|_, value| !value.is_null());
    }
    object
}

struct FieldPerLine {
    depth: usize,
    /// Whether the object just begun has no field so far.
    empty: bool,
}

impl FieldPerLine {
    fn new_line<W: Write + ?Sized>(&self, writer: &mut W) -> io::Result<()> {
        write!(writer, "\n{:1$}", "", INDENT * self.depth)
    }
}

impl Formatter for FieldPerLine {
    fn begin_array_value<W: Write + ?Sized>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first {
            Ok(())
        } else {
            writer.write_all(b", ")
        }
    }

    fn begin_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        self.empty = true;
        writer.write_all(b"{")
    }

    fn begin_object_key<W: Write + ?Sized>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.empty = false;
        if !first {
            writer.write_all(b",")?;
        }
        self.new_line(writer)
    }

    fn begin_object_value<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object<W: Write + ?Sized>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        if !self.empty {
            self.new_line(writer)?;
        }
        self.empty = false;
        writer.write_all(b"}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn objects_in_arrays_and_empty_ones() {
        let value = json!({ "a": [{ "b": [1, 2], "c": {} }, { "d": [] }] });
        let text = to_json(&value).unwrap();
        let expected =
            "{\n  \"a\": [{\n    \"b\": [1, 2],\n    \"c\": {}\n  }, {\n    \"d\": []\n  }]\n}\n";
        assert_eq!(text, expected);
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap(), value);
    }
}
