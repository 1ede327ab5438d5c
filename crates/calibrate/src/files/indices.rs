//! The matrices `covariance.npy` and `reliability.npy` with their indices in JSON, version 1.
//!
//! The covariance has a row and a column for each result. The matrix of reliability has a row for each used
//! length and a column for each result: what the smallest detectable error of the length does to the result.
//! The indices name the results, in their order: position in mm or degrees as in `calibration.json`, direction
//! 1 or -1 where the sides of approach are kept apart, and the unit of the number. That of reliability has one
//! array for each property of the lengths, in the order of the rows.

use serde::{Serialize, Serializer};
use serde_json::json;
use trueaxis_campaign::{Direction, Lengths};
use trueaxis_files::round;
use trueaxis_kinematics::MICROMETRE;

use crate::files::{text, without_nulls};
use crate::replay::reliability::{LengthReliability, LengthsReliability};
use crate::result::numbered::NumberedResult;
use crate::result::output::{Output, OutputCovariance, position_in_file};

/// As files name a result.
impl Serialize for Output {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (mut position_in_unit, mut side) = (None, None);
        let (axis, station) = match self {
            Self::ComponentError {
                axis,
                kind,
                position,
                direction,
                ..
            } => {
                position_in_unit = Some(position_in_file(*kind, *position));
                side = direction.map(Direction::sign);
                (Some(axis), None)
            }
            Self::LocationError { axis, .. } => (Some(axis), None),
            Self::StationPosition { station, .. } | Self::DeadPath { station } => {
                (None, Some(station))
            }
        };
        let entry = json!({
            "name": self.name(),
            "axis": axis,
            "station": station,
            "position": position_in_unit,
            "direction": side,
            "unit": self.unit().suffix(),
        });
        without_nulls(entry).serialize(serializer)
    }
}

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
        text(&json!({
            "format": "trueaxis-covariance",
            "version": 1,
            "matrix": Self::MATRIX_FILE,
            "outputs": self.outputs,
        }))
    }
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
        let of = |f: &dyn Fn(&LengthReliability) -> f64| -> Vec<f64> {
            self.lengths.iter().map(|l| round(f(l), 6)).collect()
        };
        let of_each = self.lengths.iter();
        let lines = of_each.clone().map(|l| lengths.readings[l.reading].line);
        let outputs = results.iter().map(|result| &result.output);
        text(&json!({
            "format": "trueaxis-reliability",
            "version": 1,
            "matrix": Self::MATRIX_FILE,
            // Line of the lengths' file, from 1 (the header).
            "row": lines.collect::<Vec<_>>(),
            "redundancy": of(&|length| length.redundancy),
            // Null where nothing checks the length.
            "minimal_detectable_um": of(&|length| length.minimal_detectable_mm / MICROMETRE),
            // Place among the results, from 0.
            "worst_result": of_each.map(|length| length.worst.0).collect::<Vec<_>>(),
            "worst_effect_in_u": of(&|length| length.worst.1),
            "results": outputs.collect::<Vec<_>>(),
        }))
    }
}
