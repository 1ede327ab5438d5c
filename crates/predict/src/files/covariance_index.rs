//! The dense matrix `covariance.npy` with its index in JSON, version 1.
//!
//! It has a row and a column for each result. The index names the results, in their order: position in mm or degrees as
//! in `calibration.json`, direction 1 or -1 where the sides of approach are kept apart, and the unit of the number.

use serde::{Serialize, Serializer};
use serde_json::json;
use trueaxis_campaign::Direction;
use trueaxis_files::{value_to_json, without_nulls};

use crate::output::{Output, OutputCovariance, position_in_file};

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
        value_to_json(&json!({
            "format": "trueaxis-covariance",
            "version": 1,
            "matrix": Self::MATRIX_FILE,
            "outputs": self.outputs,
        }))
    }
}
