//! The matrix `reliability.npy` with its index in JSON, version 1: the effect of the smallest detectable error of
//! each used length (row) on each result (column).
//!
//! The index has one array for each property of the lengths, in the order of the rows, and names the results in the
//! same way as that of the covariance.

use serde_json::json;
use trueaxis_campaign::Lengths;
use trueaxis_files::{round, value_to_json};
use trueaxis_kinematics::MICROMETRE;

use crate::replay::reliability::{LengthReliability, LengthsReliability};
use crate::result::numbered::NumberedResult;

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
        let of = |f: &dyn Fn(&LengthReliability) -> f64| -> Vec<f64> {
            self.lengths.iter().map(|l| round(f(l), 6)).collect()
        };
        let of_each = self.lengths.iter();
        let lines = of_each.clone().map(|l| lengths.readings[l.reading].line);
        let outputs = results.iter().map(|result| &result.output);
        value_to_json(&json!({
            "format": "trueaxis-reliability",
            "version": 1,
            "matrix": Self::MATRIX_FILE,
            // Line of the lengths' file, from 1 (the header).
            "row": lines.collect::<Vec<_>>(),
            "redundancy": of(&|length| length.redundancy),
            // Null for a length that nothing checks.
            "minimal_detectable_um": of(&|length| length.minimal_detectable_mm / MICROMETRE),
            // Index among the results, from 0.
            "worst_result": of_each.map(|length| length.worst.0).collect::<Vec<_>>(),
            "worst_effect_in_u": of(&|length| length.worst.1),
            "results": outputs.collect::<Vec<_>>(),
        }))
    }
}
