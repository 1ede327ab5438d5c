//! Names that nothing has: which known one was probably meant, in files and in the parser's messages.

use crate::error::{Error, Problem};

/// The index of a name among the known ones, or what was probably meant.
pub(crate) fn index_of(
    field: impl Into<String>,
    what: impl Into<String>,
    name: &str,
    known: &[&str],
) -> Result<usize, Error> {
    let unknown = || Problem::UnknownName {
        what: what.into(),
        name: name.to_owned(),
        nearest: nearest(name, known.iter().copied()),
        known: known.join(", "),
    };
    let found = known.iter().position(|&other| other == name);
    found.ok_or_else(|| unknown().at(field))
}

/// The parser's message without its place, and what an unknown field may have meant.
///
/// serde writes ``unknown field `a`, expected one of `b`, `c` ``.
pub(crate) fn json_error(path: &str, error: &serde_json::Error) -> Error {
    let message = error.to_string();
    let place = format!(" at line {} column {}", error.line(), error.column());
    let message = message.strip_suffix(&place).unwrap_or(&message);
    let nearest = message.starts_with("unknown").then(|| {
        let mut quoted = message.split('`').skip(1).step_by(2);
        let found = quoted.next().unwrap_or_default();
        nearest(found, quoted)
    });
    Error::Json {
        field: (path != ".").then(|| path.to_owned()),
        line: error.line(),
        message: message.to_owned(),
        nearest: nearest.flatten(),
    }
}

/// The known name most like `found`, if at most half of the letters differ; case does not count, and a
/// swap of two neighbours is one difference.
fn nearest<'a>(found: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let found = found.to_lowercase();
    let edits = |name: &str| strsim::damerau_levenshtein(&found, &name.to_lowercase());
    let rated = known.into_iter().map(|name| (edits(name), name));
    rated
        .filter(|&(edits, name)| 2 * edits <= found.chars().count().max(name.chars().count()))
        .min_by_key(|&(edits, _)| edits)
        .map(|(_, name)| name.to_owned())
}
