//! Results as files.

mod adjustment_json;
mod calibration_json;
mod reliability_files;
mod residuals_csv;

use serde_json::Value;

/// The text of a file.
fn text(value: &Value) -> String {
    // A value of numbers and strings has no way to fail.
    trueaxis_files::to_json(value).expect("numbers and strings serialise")
}

/// An object without its fields that are null: the optional ones that do not apply.
fn without_nulls(mut object: Value) -> Value {
    if let Value::Object(fields) = &mut object {
        fields.retain(|_, value| !value.is_null());
    }
    object
}

/// An array of what there is; null if there is nothing.
fn unless_empty<T>(all: &[T], entry: impl Fn(&T) -> Value) -> Value {
    match all.is_empty() {
        true => Value::Null,
        false => all.iter().map(entry).collect(),
    }
}
