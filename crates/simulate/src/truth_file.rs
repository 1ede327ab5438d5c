//! `truth.json`: the truth in the shape and units of `calibration.json`.
//!
//! Values are rounded to nine decimals of mm, deg, µm or arcsec: far below the rounding of the lengths,
//! and without the digits that unit conversion leaves.

use std::path::Path;

use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use trueaxis_campaign::Direction;
use trueaxis_files::{Place, round, without_nulls};
use trueaxis_kinematics::{ARCSEC, Component};

use crate::true_errors::unit_of;
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
            .map_err(|source| Problem::Write(source).in_place(Place::file(path)))
    }
}

impl Serialize for Truth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let reflectors = self.reflectors.iter().map(|reflector| {
            let constant_um = round(reflector.constant_um, DECIMALS);
            json!({ "name": reflector.name, "constant_um": constant_um })
        });
        let stations = self.stations.iter().map(|station| {
            let position_mm = <[f64; 3]>::from(station.position_mm);
            json!({ "name": station.name, "position_mm": position_mm, "dead_path_mm": station.dead_path_mm })
        });
        let targets = self.targets.iter().map(|target| {
            let position_mm = <[f64; 3]>::from(target.home_mm.map(|c| round(c, DECIMALS)));
            json!({ "name": target.name, "position_mm": position_mm })
        });
        let locations = self.location_errors.iter();
        let locations = locations.map(|location| (location.name.clone(), of_location(location)));
        // A campaign with an ideal scale and ideal reflectors says nothing about them.
        let has_scale = self.scale_ppm.abs() > 0.0;
        let has_constants = self.reflectors.iter().any(|r| r.constant_um.abs() > 0.0);
        let file = without_nulls(json!({
            "format": Self::FORMAT,
            "version": Self::VERSION,
            "campaign": self.campaign,
            "seed": self.seed,
            "noise": self.noise,
            "scale_ppm": has_scale.then(|| round(self.scale_ppm, DECIMALS)),
            "reflectors": has_constants.then(|| reflectors.collect::<Value>()),
            "stations": stations.collect::<Value>(),
            "targets": targets.collect::<Value>(),
            "axes": self.axes.iter().map(of_axis).collect::<Value>(),
            "location_errors": locations.collect::<Value>(),
            "effects": (!self.effects.is_empty()).then_some(&self.effects),
        }));
        file.serialize(serializer)
    }
}

fn of_axis(axis: &TrueComponents) -> Value {
    let positions = axis.positions.iter();
    let positions = positions.map(|&q| round(axis.kind.position_in_file(q), DECIMALS));
    let components = Component::ALL.into_iter().map(|component| {
        let field = match component.is_angular() {
            true => "value_arcsec",
            false => "value_um",
        };
        let values = axis.errors.iter().map(|e| e.to_vector()[component.index()]);
        let values = values.map(|value| round(value / unit_of(component), DECIMALS));
        let values = json!({ field: values.collect::<Value>() });
        (component.name(&axis.name), values)
    });
    let signs = |sides: &Vec<Direction>| sides.iter().map(|side| side.sign()).collect::<Value>();
    without_nulls(json!({
        "name": axis.name,
        "kind": axis.kind.name(),
        "unit": axis.kind.position_unit(),
        "positions": positions.collect::<Value>(),
        "direction": axis.directions.as_ref().map(signs),
        "reference_point_mm": <[f64; 3]>::from(axis.reference_mm),
        "components": components.collect::<Value>(),
    }))
}

fn of_location(location: &TrueLocation) -> Value {
    match location.component.is_angular() {
        true => json!({ "value_arcsec": round(location.value / ARCSEC, DECIMALS) }),
        false => json!({ "value_mm": round(location.value, DECIMALS) }),
    }
}
