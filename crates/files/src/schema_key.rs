//! The key `$schema` at the top of a document: editors read it, the program does not.

use std::borrow::Cow;

use crate::field_span;

/// The text with blanks in place of a top-level `$schema`, so that all else keeps its place.
///
/// The text must be a JSON object.
pub(crate) fn without_schema_key(json: &str) -> Cow<'_, str> {
    let Some(span) = field_span(json, "$schema") else {
        return json.into();
    };
    let (mut before, mut behind) = (json[..span.start].to_owned(), json[span.end..].to_owned());
    let blank = |text: &str| text.replace(|c: char| !c.is_whitespace(), " ");
    let key = blank(&json[span]);
    // One of the two commas beside it goes with it.
    if behind.trim_start().starts_with(',') {
        behind = behind.replacen(',', " ", 1);
    } else if let Some(comma) = before.trim_end().strip_suffix(',').map(str::len) {
        before.replace_range(comma..=comma, " ");
    }
    (before + &key + &behind).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_else_keeps_its_place() {
        for (text, key) in [
            (
                "{\n \"$schema\": \"s\",\n \"a\": 1\n}",
                "\"$schema\": \"s\",",
            ),
            ("{ \"a\": 1, \"$schema\" : \"s\" }", ", \"$schema\" : \"s\""),
            ("{ \"$schema\": \"s\" }", "\"$schema\": \"s\""),
            ("{ \"a\": { \"$schema\": 1 } }", ""),
        ] {
            let expected = text.replace(key, &" ".repeat(key.len()));
            assert_eq!(without_schema_key(text), expected);
        }
    }
}
