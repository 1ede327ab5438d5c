//! The machine and its predictions as files.

pub(crate) mod covariance_index;
pub(crate) mod covariance_npz;
pub(crate) mod predicted_csv;
mod read_calibration;
pub(crate) mod read_error;
mod volume_files;

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
