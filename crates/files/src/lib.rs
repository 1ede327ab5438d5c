//! Result files that are whole and that people can read.
//!
//! [`write_whole`] writes a file under a temporary name beside its place and renames it: whoever
//! looks sees the old file or the new one, never a part. [`to_json`] is JSON with one line for each
//! field, arrays of numbers included, so that a curve is a line and not a column. [`to_npy`] is a
//! `NumPy` file for arrays that are too large for text.
//!
//! ```
//! use serde::Serialize;
//!
//! #[derive(Serialize)]
//! struct Curve {
//!     name: &'static str,
//!     positions: [f64; 3],
//! }
//! let curve = Curve { name: "EXX", positions: [0.0, 20.0, 40.0] };
//! let text = trueaxis_files::to_json(&curve)?;
//! assert_eq!(text, "{\n  \"name\": \"EXX\",\n  \"positions\": [0.0, 20.0, 40.0]\n}\n");
//!
//! let folder = tempfile::tempdir()?;
//! trueaxis_files::write_whole(&folder.path().join("curve.json"), text.as_bytes())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod json;
mod npy;
mod whole;

pub use json::to_json;
pub use npy::to_npy;
pub use whole::write_whole;
