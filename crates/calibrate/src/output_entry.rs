//! How files name a result.

use serde::Serialize;

use crate::json::{direction_in_file, position_in_file};
use crate::output_covariance::Output;

/// What a result is, as files say it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutputEntry<'a> {
    /// ISO 230-1 name of an error; `x`, `y`, `z` or `dead_path` of a station.
    pub name: String,
    /// The axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<&'a str>,
    /// The station.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<&'a str>,
    /// Commanded position, mm or degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<f64>,
    /// Side of approach, 1 or -1, where the two are kept apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<i8>,
    /// Unit of its values: `um`, `arcsec` or `mm`.
    pub unit: &'static str,
}

impl<'a> OutputEntry<'a> {
    /// The entry of an output.
    pub fn new(output: &'a Output) -> Self {
        let mut entry = Self {
            name: output.name(),
            axis: None,
            station: None,
            position: None,
            direction: None,
            unit: output.unit().suffix(),
        };
        match output {
            Output::ComponentError {
                axis,
                kind,
                position,
                direction,
                ..
            } => {
                entry.axis = Some(axis);
                entry.position = Some(position_in_file(*kind, *position));
                entry.direction = direction.map(direction_in_file);
            }
            Output::LocationError { axis, .. } => entry.axis = Some(axis),
            Output::StationPosition { station, .. } | Output::DeadPath { station } => {
                entry.station = Some(station);
            }
        }
        entry
    }
}
