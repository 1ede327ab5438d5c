//! Names in a CSV file.

use std::borrow::Cow;

/// The cell of a CSV file with this text: in quotes if it needs them (RFC 4180).
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")).into(),
        false => text.into(),
    }
}
