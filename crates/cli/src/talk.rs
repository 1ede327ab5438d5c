//! What is said to the user, on standard error.

use std::io::Write;

/// One line. A closed standard error is no reason to fail.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// An error with its causes.
pub(crate) fn error(error: &anyhow::Error) {
    let mut causes = error.chain();
    let first = causes.next().map(ToString::to_string).unwrap_or_default();
    say(&format!("error: {first}"));
    for cause in causes {
        say(&format!("  because: {cause}"));
    }
}

/// Something that the user must know although there is a result.
pub(crate) fn notice(text: &str) {
    say(&format!("notice: {text}"));
}
