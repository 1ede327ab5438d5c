//! What a verb with `--json` prints where there is no result, for programs that read it.

use serde_json::json;
use trueaxis_files::value_to_json;

use crate::codes;
use crate::drawing::{self, Spot};
use crate::exit::Exit;
use crate::explain;

/// The text of the document.
pub(crate) fn text(error: &anyhow::Error, exit: Exit) -> String {
    let code = codes::of(error);
    let at = Spot::of(error).map(|spot| spot.line_and_column());
    let messages = error.chain().map(ToString::to_string);
    let document = json!({
        "format": "trueaxis-error",
        "version": 1,
        "code": code,
        "exit_code": exit as u8,
        "message": messages.collect::<Vec<_>>().join(": "),
        "file": drawing::file(error).map(|file| file.display().to_string()),
        "line": at.map(|(line, _)| line),
        "column": at.map(|(_, column)| column),
        "help": code.and_then(explain::help),
    });
    value_to_json(&document)
}
