//! What a verb with `--json` prints where there is no result, for programs that read it.

use serde::Serialize;

use crate::codes;
use crate::drawing::{self, Spot};
use crate::exit::Exit;
use crate::explain;

#[derive(Serialize)]
struct File {
    format: &'static str,
    version: u32,
    code: Option<&'static str>,
    exit_code: u8,
    message: String,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    help: Option<&'static str>,
}

/// The text of the document.
pub(crate) fn text(error: &anyhow::Error, exit: Exit) -> String {
    let code = codes::of(error);
    let at = Spot::of(error).map(|spot| spot.line_and_column());
    let messages = error.chain().map(ToString::to_string);
    let file = File {
        format: "trueaxis-error",
        version: 1,
        code,
        exit_code: exit.code(),
        message: messages.collect::<Vec<_>>().join(": "),
        file: drawing::file(error).map(|file| file.display().to_string()),
        line: at.map(|(line, _)| line),
        column: at.map(|(_, column)| column),
        help: code.and_then(explain::help),
    };
    // Serialising plain structs of numbers and strings has no way to fail.
    trueaxis_files::to_json(&file).expect("numbers and strings serialise")
}
