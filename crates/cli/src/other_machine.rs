//! A calibration that is of another machine than what it is compared with: the message names both files.

use std::path::Path;

use crate::codes;

/// The error with its file, or with both if the machines differ.
pub(crate) fn placed(
    error: impl Into<anyhow::Error>,
    calibration: &Path,
    other: &Path,
) -> anyhow::Error {
    let error = error.into();
    let other = other.display();
    match codes::of(&error) {
        Some("E503") => error.context(format!("{} for {other}", calibration.display())),
        _ => error.context(other.to_string()),
    }
}
