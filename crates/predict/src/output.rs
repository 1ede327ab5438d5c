//! The numbers of a calibration: their names, units and covariance.

use std::collections::BTreeMap;

use nalgebra::DMatrix;
use trueaxis_campaign::Direction;
use trueaxis_files::round;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, LocationComponent, MICROMETRE, Machine};

use crate::factored_covariance::FactoredCovariance;

/// Covariance of all results of a calibration, in the units of `calibration.json`.
///
/// What gauge or frame define has zero rows and columns.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputCovariance {
    /// The results in the order of rows and columns: the component errors of all axes (for each
    /// position all six), the location errors, the stations (x y z and dead path of each).
    pub outputs: Vec<Output>,
    /// The covariance: element (i, j) has the unit of output i times that of output j.
    pub matrix: DMatrix<f64>,
}

impl OutputCovariance {
    /// Of these results, all of their calibration.
    pub fn new(factors: &FactoredCovariance, outputs: Vec<Output>) -> Self {
        let sizes: Vec<f64> = outputs.iter().map(|o| o.unit().size()).collect();
        let mut matrix = factors.dense();
        for (j, mut column) in matrix.column_iter_mut().enumerate() {
            for (value, size) in column.iter_mut().zip(&sizes) {
                *value /= size * sizes[j];
            }
        }
        Self { outputs, matrix }
    }
}

/// One number of a calibration.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// A component error at a measured position.
    ComponentError {
        /// Name of the axis.
        axis: String,
        /// Linear or rotary.
        kind: AxisKind,
        /// Which of the six.
        component: Component,
        /// Commanded position, mm or rad.
        position: f64,
        /// Side of approach, where the two are kept apart.
        direction: Option<Direction>,
    },
    /// A location error.
    LocationError {
        /// Name of the axis.
        axis: String,
        /// Which one.
        component: LocationComponent,
    },
    /// A coordinate of a station.
    StationPosition {
        /// Name of the station.
        station: String,
        /// 0, 1, 2 for x, y, z.
        coordinate: usize,
    },
    /// The dead path of a station.
    DeadPath {
        /// Name of the station.
        station: String,
    },
}

/// Unit of an output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// µm.
    Micrometre,
    /// Seconds of arc.
    Arcsec,
    /// mm.
    Millimetre,
}

impl Output {
    /// ISO 230-1 name of an error; `x`, `y`, `z` or `dead_path` of a station.
    pub fn name(&self) -> String {
        match self {
            Self::ComponentError {
                axis, component, ..
            } => component.name(axis),
            Self::LocationError { axis, component } => component.name(axis),
            Self::StationPosition { coordinate, .. } => ["x", "y", "z"][*coordinate].to_owned(),
            Self::DeadPath { .. } => "dead_path".to_owned(),
        }
    }

    /// Its unit, that of `calibration.json`.
    pub fn unit(&self) -> Unit {
        match self {
            Self::ComponentError { component, .. } => Unit::of_component(*component),
            Self::LocationError { component, .. } => Unit::of_location(*component),
            Self::StationPosition { .. } | Self::DeadPath { .. } => Unit::Millimetre,
        }
    }
}

impl Unit {
    /// Of a component error.
    pub fn of_component(component: Component) -> Self {
        match component.is_angular() {
            true => Self::Arcsec,
            false => Self::Micrometre,
        }
    }

    /// Of a location error.
    pub fn of_location(component: LocationComponent) -> Self {
        match component.is_angular() {
            true => Self::Arcsec,
            false => Self::Millimetre,
        }
    }

    /// mm or rad.
    pub fn size(self) -> f64 {
        match self {
            Self::Micrometre => MICROMETRE,
            Self::Arcsec => ARCSEC,
            Self::Millimetre => 1.0,
        }
    }

    /// A value (mm or rad) in this unit, rounded far below anything measurable.
    pub fn in_file(self, value: f64) -> f64 {
        let decimals = match self {
            Self::Millimetre => 9,
            Self::Micrometre | Self::Arcsec => 6,
        };
        round(value / self.size(), decimals)
    }

    /// As field names end: `um`, `arcsec`, `mm`.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Micrometre => "um",
            Self::Arcsec => "arcsec",
            Self::Millimetre => "mm",
        }
    }
}

/// Where the axes of a machine stand that are not at home (mm or rad; none at several places), by name, as files have it; `None` if
/// all are at home.
pub fn positions_in_file(
    machine: &Machine,
    positions: &[Option<f64>],
) -> Option<BTreeMap<String, Option<f64>>> {
    let all = machine.axes().iter().zip(positions);
    let away = all.filter(|(_, position)| **position != Some(0.0));
    let in_file = away.map(|(axis, position)| {
        let in_file = |position| round(position_in_file(axis.kind(), position), 6);
        (axis.name().to_owned(), position.map(in_file))
    });
    let away: BTreeMap<String, Option<f64>> = in_file.collect();
    (!away.is_empty()).then_some(away)
}

/// A commanded position (mm or rad) as files have it, mm or degrees.
pub fn position_in_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position,
        AxisKind::Rotary => round(position.to_degrees(), 9),
    }
}
