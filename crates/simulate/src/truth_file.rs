//! `truth.json`: the truth in the shape and units of `calibration.json`.
//!
//! Values are rounded to nine decimals of mm, deg, µm or arcsec: far below the rounding of the lengths,
//! and without the digits that unit conversion leaves.

use std::path::Path;

use nalgebra::Point3;
use serde::ser::{Serialize, SerializeStruct, Serializer};
use trueaxis_campaign::Direction;
use trueaxis_files::{Ordered, Place, round};
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MICROMETRE};

use crate::axis_unit;
use crate::{Error, Problem, TrueComponents, TrueLocation, Truth};

/// Decimals of the values.
const DECIMALS: i32 = 9;

impl Truth {
    /// What `format` says in `truth.json`.
    pub const FORMAT: &str = "trueaxis-truth";
    /// The version of the format that is written.
    pub const VERSION: u32 = 1;

    /// Writes `truth.json`: to a temporary file beside `path`, which is then renamed.
    ///
    /// # Errors
    /// [`Problem::Write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        trueaxis_files::to_json(self)
            .map_err(std::io::Error::from)
            .and_then(|text| trueaxis_files::write_whole(path, text.as_bytes()))
            .map_err(|source| Error {
                place: Place::file(path),
                problem: Box::new(Problem::Write(source)),
            })
    }
}

impl Serialize for Truth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let locations = self.location_errors.iter();
        let locations = locations.map(|location| (location.name.clone(), location));
        let mut file = serializer.serialize_struct("Truth", 12)?;
        file.serialize_field("format", Self::FORMAT)?;
        file.serialize_field("version", &Self::VERSION)?;
        file.serialize_field("campaign", &self.campaign)?;
        file.serialize_field("seed", &self.seed)?;
        file.serialize_field("noise", &self.noise)?;
        // A campaign with an ideal scale and ideal reflectors says nothing about them.
        if self.scale_ppm.abs() > 0.0 {
            file.serialize_field("scale_ppm", &round(self.scale_ppm, DECIMALS))?;
        }
        if self.reflectors.iter().any(|r| r.constant_um.abs() > 0.0) {
            file.serialize_field("reflectors", &self.reflectors)?;
        }
        file.serialize_field("stations", &self.stations)?;
        file.serialize_field("targets", &self.targets)?;
        file.serialize_field("axes", &self.axes)?;
        file.serialize_field("location_errors", &locations.collect::<Ordered<_>>())?;
        if !self.effects.is_empty() {
            file.serialize_field("effects", &self.effects)?;
        }
        file.end()
    }
}

impl Serialize for TrueComponents {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (kind, unit) = match self.kind {
            AxisKind::Linear => ("linear", "mm"),
            AxisKind::Rotary => ("rotary", "deg"),
        };
        let positions = self.positions.iter();
        let positions = positions.map(|&q| round(axis_unit::to_file(self.kind, q), DECIMALS));
        let components = Component::ALL.map(|component| {
            let values = self.errors.iter().map(|e| e.to_vector()[component.index()]);
            let values = values.map(|value| in_file(value, component.is_angular()));
            let name = if component.is_angular() {
                "value_arcsec"
            } else {
                "value_um"
            };
            let curve: Ordered<Vec<f64>> =
                [(name.to_owned(), values.collect())].into_iter().collect();
            (component.name(&self.name), curve)
        });
        let mut axis = serializer.serialize_struct("TrueComponents", 7)?;
        axis.serialize_field("name", &self.name)?;
        axis.serialize_field("kind", kind)?;
        axis.serialize_field("unit", unit)?;
        axis.serialize_field("positions", &positions.collect::<Vec<_>>())?;
        if let Some(directions) = &self.directions {
            let signs = directions.iter().map(|direction| match direction {
                Direction::Forward => 1,
                Direction::Backward => -1,
            });
            axis.serialize_field("direction", &signs.collect::<Vec<i8>>())?;
        }
        axis.serialize_field("reference_point_mm", &<[f64; 3]>::from(self.reference_mm))?;
        axis.serialize_field(
            "components",
            &components.into_iter().collect::<Ordered<_>>(),
        )?;
        axis.end()
    }
}

impl Serialize for TrueLocation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut location = serializer.serialize_struct("TrueLocation", 1)?;
        if self.component.is_angular() {
            location.serialize_field("value_arcsec", &in_file(self.value, true))?;
        } else {
            location.serialize_field("value_mm", &round(self.value, DECIMALS))?;
        }
        location.end()
    }
}

/// A component error: µm of mm, or arcsec of rad.
fn in_file(value: f64, angular: bool) -> f64 {
    let unit = if angular { ARCSEC } else { MICROMETRE };
    round(value / unit, DECIMALS)
}

/// Coordinates as they are.
pub(crate) fn point<S: Serializer>(point: &Point3<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    <[f64; 3]>::from(*point).serialize(serializer)
}

/// Coordinates rounded as all values are.
pub(crate) fn rounded<S: Serializer>(
    point: &Point3<f64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    <[f64; 3]>::from(point.map(|c| round(c, DECIMALS))).serialize(serializer)
}

/// A number rounded as all values are.
pub(crate) fn rounded_number<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    round(*value, DECIMALS).serialize(serializer)
}
