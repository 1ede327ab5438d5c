//! Results as files.

mod adjustment_json;
mod calibration_json;
mod reliability_files;
mod residuals_csv;

use serde_json::Value;

/// An array of the entries; null if there are none.
fn unless_empty<T>(all: &[T], entry: impl Fn(&T) -> Value) -> Value {
    match all.is_empty() {
        true => Value::Null,
        false => all.iter().map(entry).collect(),
    }
}
