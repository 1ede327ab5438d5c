//! What is said to the user, on standard error.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::drawing::Spot;
use crate::{codes, progress};

static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only errors are said.
pub(crate) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether only errors are said.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// One line, unless all shall be quiet.
pub(crate) fn say(line: &str) {
    if !is_quiet() {
        say_always(line);
    }
}

/// Line after line, unless all shall be quiet.
pub(crate) fn say_all(lines: impl IntoIterator<Item: AsRef<str>>) {
    lines.into_iter().for_each(|line| say(line.as_ref()));
}

/// One line. A closed standard error is no reason to fail.
pub(crate) fn say_always(line: &str) {
    progress::end_clock();
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// An error with its code and its causes, drawn on the line where it is.
pub(crate) fn error(error: &anyhow::Error) {
    let mut causes = error.chain();
    let first = causes.next().map(ToString::to_string).unwrap_or_default();
    let code = codes::of(error);
    let in_brackets = code.map(|code| format!("[{code}]")).unwrap_or_default();
    say_always(&format!("error{in_brackets}: {first}"));
    for cause in causes {
        say_always(&format!("  because: {cause}"));
    }
    for line in Spot::of(error).iter().flat_map(Spot::drawn) {
        say_always(&line);
    }
    if let Some(code) = code {
        say_always(&format!("more: trueaxis explain {code}"));
    }
}

/// Something that the user must know although there is a result.
pub(crate) fn notice(text: &str) {
    say(&format!("notice: {text}"));
}

/// Notice after notice.
pub(crate) fn notice_all(texts: impl IntoIterator<Item: AsRef<str>>) {
    texts.into_iter().for_each(|text| notice(text.as_ref()));
}
