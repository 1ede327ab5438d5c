//! The machine and its predictions as files.

pub(crate) mod comparison_json;
pub(crate) mod covariance_index;
pub(crate) mod covariance_npz;
pub(crate) mod predicted_csv;
mod read_calibration;
pub(crate) mod read_error;
mod volume_files;
