//! `reliability.npy` and its index `reliability.json`, version 1.
//!
//! The matrix has a row for each used length and a column for each result: what the smallest
//! detectable error of the length does to the result. The index has one array for each property of
//! the lengths, in the order of the rows, and names the columns.

use serde::Serialize;
use trueaxis_campaign::Lengths;
use trueaxis_kinematics::MICROMETRE;

use crate::output_entry::OutputEntry;
use crate::reliability::{LengthReliability, LengthsReliability};
use crate::results::NumberedResult;

#[derive(Serialize)]
struct Index<'a> {
    format: &'static str,
    version: u32,
    matrix: &'static str,
    /// Line of the lengths' file, from 1 (the header).
    row: Vec<usize>,
    redundancy: Vec<f64>,
    /// Null where nothing checks the length.
    minimal_detectable_um: Vec<Option<f64>>,
    /// Place among the results, from 0.
    worst_result: Vec<usize>,
    worst_effect_in_u: Vec<f64>,
    results: Vec<OutputEntry<'a>>,
}

impl LengthsReliability {
    /// Name of the file of [`LengthsReliability::to_npy`], as the index states it.
    pub const MATRIX_FILE: &str = "reliability.npy";

    /// The effects as a `NumPy` file.
    pub fn to_npy(&self) -> Vec<u8> {
        let (rows, columns) = self.effects.shape();
        let by_rows = self.effects.transpose();
        trueaxis_files::to_npy(&[rows, columns], by_rows.iter().copied())
    }

    /// The text of `reliability.json`; `results` are those of the replay, `lengths` those of the
    /// campaign.
    pub fn index_json(&self, results: &[NumberedResult], lengths: &Lengths) -> String {
        let rounded = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
        let of = |f: &dyn Fn(&LengthReliability) -> f64| -> Vec<f64> {
            self.lengths.iter().map(|l| rounded(f(l))).collect()
        };
        let detectable_um = self.lengths.iter().map(|length| {
            let um = length.minimal_detectable_mm / MICROMETRE;
            um.is_finite().then(|| rounded(um))
        });
        let index = Index {
            format: "trueaxis-reliability",
            version: 1,
            matrix: Self::MATRIX_FILE,
            row: self
                .lengths
                .iter()
                .map(|length| lengths.readings[length.reading].line)
                .collect(),
            redundancy: of(&|length| length.redundancy),
            minimal_detectable_um: detectable_um.collect(),
            worst_result: self.lengths.iter().map(|length| length.worst.0).collect(),
            worst_effect_in_u: of(&|length| length.worst.1),
            results: results
                .iter()
                .map(|r| OutputEntry::new(&r.output))
                .collect(),
        };
        // Serialising plain structs of numbers and strings has no way to fail.
        trueaxis_files::to_json(&index).expect("numbers and strings serialise")
    }
}
