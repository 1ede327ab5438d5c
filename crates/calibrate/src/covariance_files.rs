//! `covariance.npy` and its index `covariance.json`, version 1.
//!
//! The index names what each row and column of the matrix is, in their order: position in mm or
//! degrees as in `calibration.json`, direction 1 or -1 where the sides of approach are kept apart,
//! and the unit of the number.

use serde::Serialize;

use crate::output_covariance::OutputCovariance;
use crate::output_entry::OutputEntry;

impl OutputCovariance {
    /// Name of the file of [`OutputCovariance::to_npy`], as the index states it.
    pub const MATRIX_FILE: &str = "covariance.npy";

    /// The matrix as a `NumPy` file.
    pub fn to_npy(&self) -> Vec<u8> {
        let (rows, columns) = self.matrix.shape();
        // Columns are rows: it is symmetric.
        trueaxis_files::to_npy(&[rows, columns], self.matrix.iter().copied())
    }

    /// The text of `covariance.json`: what the rows and columns are.
    pub fn index_json(&self) -> String {
        let index = Index {
            format: "trueaxis-covariance",
            version: 1,
            matrix: Self::MATRIX_FILE,
            outputs: self.outputs.iter().map(OutputEntry::new).collect(),
        };
        // Serialising plain structs of numbers and strings has no way to fail.
        trueaxis_files::to_json(&index).expect("numbers and strings serialise")
    }
}

#[derive(Serialize)]
struct Index<'a> {
    format: &'static str,
    version: u32,
    matrix: &'static str,
    outputs: Vec<OutputEntry<'a>>,
}
