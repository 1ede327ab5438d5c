//! Files: reading input with precise errors, writing readable results atomically.
//!
//! [`Format::read`] reads a JSON document; what is wrong with it has a [`Place`] and, for an unknown
//! name, the [`Alternatives`].
//!
//! [`write_whole`] writes a file under a temporary name beside its place and renames it: readers
//! see either the old file or the new one, never a part of it. [`to_json`] is JSON with one line for each
//! field, arrays of numbers included, so that a curve is a line and not a column. [`to_npy`] is a
//! `NumPy` file for arrays that are too large for text, [`NpzWriter`] writes several of them into one file.
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

mod alternatives;
mod counted;
mod csv_cell;
mod document;
mod document_error;
mod field_line;
mod file_problem;
mod json;
mod located;
mod names;
mod npy;
mod npz;
mod ordered;
mod p_value;
mod place;
mod rounding;
mod schema;
mod schema_key;
mod serde_message;
mod sha256;
mod told_effect;
mod told_unit;
mod unique_keys;
mod whole;

pub use alternatives::Alternatives;
pub use counted::counted;
pub use csv_cell::csv_cell;
pub use document::Format;
pub use document_error::{DocumentError, DocumentProblem};
pub use field_line::{field_line, field_span};
pub use file_problem::{FileProblem, read_bytes};
pub use json::{to_json, value_to_json, without_nulls};
pub use located::{Located, OfDocument};
pub use names::{check_name, check_names, index_of};
pub use npy::{Array, NpyError, from_npy, to_npy};
pub use npz::{NpzError, NpzWriter, WriteSeek, from_npz};
pub use ordered::Ordered;
pub use p_value::{p_value, probability};
pub use place::{Part, Place};
pub use rounding::{decimals, point_mm, push_rounded, round, significant};
pub use schema::nullable_text;
pub use sha256::sha256;
pub use told_effect::told_effect;
pub use told_unit::{told_behind, told_period, told_places, told_span, told_unit, unit_symbol};
pub use unique_keys::unique_keys;
pub use whole::{write_derived, write_whole, write_whole_by};
