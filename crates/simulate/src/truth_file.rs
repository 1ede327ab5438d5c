//! `truth.json`: the truth in the shape and units of `calibration.json`.

use std::path::Path;

use serde::{Serialize, Serializer};
use trueaxis_campaign::Direction;
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, LocationComponent, MICROMETRE};

use crate::axis_unit;
use crate::{Error, TrueComponents, TrueLocation, Truth};

impl Truth {
    /// What `format` says in `truth.json`.
    pub const FORMAT: &str = "trueaxis-truth";
    /// The version of the format that is written.
    pub const VERSION: u32 = 1;

    /// Writes `truth.json`: to a temporary file beside `path`, which is then renamed.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        trueaxis_files::to_json(self)
            .map_err(std::io::Error::from)
            .and_then(|text| trueaxis_files::write_whole(path, text.as_bytes()))
            .map_err(|source| Error::Write {
                path: path.to_owned(),
                source,
            })
    }
}

impl Serialize for Truth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        TruthFile::new(self).serialize(serializer)
    }
}

#[derive(Serialize)]
struct TruthFile<'a> {
    format: &'a str,
    version: u32,
    campaign: &'a str,
    seed: u64,
    noise: NoiseEntry,
    stations: Vec<StationEntry<'a>>,
    targets: Vec<TargetEntry<'a>>,
    axes: Vec<AxisEntry<'a>>,
    location_errors: InOrder<LocationEntry>,
    #[serde(skip_serializing_if = "<[GivenEffect]>::is_empty")]
    effects: &'a [GivenEffect],
}

#[derive(Serialize)]
struct NoiseEntry {
    length_sigma_um: f64,
    length_sigma_ppm: f64,
    repeatability_um: f64,
}

#[derive(Serialize)]
struct StationEntry<'a> {
    name: &'a str,
    position_mm: [f64; 3],
    dead_path_mm: f64,
}

#[derive(Serialize)]
struct TargetEntry<'a> {
    name: &'a str,
    position_mm: [f64; 3],
}

#[derive(Serialize)]
struct AxisEntry<'a> {
    name: &'a str,
    kind: &'a str,
    unit: &'a str,
    positions: Vec<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<Vec<i8>>,
    reference_point_mm: [f64; 3],
    components: InOrder<ComponentEntry>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ComponentEntry {
    Linear { value_um: Vec<f64> },
    Angular { value_arcsec: Vec<f64> },
}

#[derive(Serialize)]
#[serde(untagged)]
enum LocationEntry {
    Offset { value_mm: f64 },
    Tilt { value_arcsec: f64 },
}

/// A map that keeps the order of its entries.
struct InOrder<V>(Vec<(String, V)>);

impl<V: Serialize> Serialize for InOrder<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'a> TruthFile<'a> {
    fn new(truth: &'a Truth) -> Self {
        let stations = truth.stations.iter().map(|station| StationEntry {
            name: &station.name,
            position_mm: station.position_mm.into(),
            dead_path_mm: station.dead_path_mm,
        });
        let targets = truth.targets.iter().map(|target| TargetEntry {
            name: &target.name,
            position_mm: target.home_mm.map(tidy).into(),
        });
        let locations = truth.location_errors.iter().map(location_entry);
        Self {
            format: Truth::FORMAT,
            version: Truth::VERSION,
            campaign: &truth.campaign,
            seed: truth.seed,
            noise: NoiseEntry {
                length_sigma_um: truth.noise.length_sigma_um,
                length_sigma_ppm: truth.noise.length_sigma_ppm,
                repeatability_um: truth.noise.repeatability_um,
            },
            stations: stations.collect(),
            targets: targets.collect(),
            axes: truth.axes.iter().map(AxisEntry::new).collect(),
            location_errors: InOrder(locations.collect()),
            effects: &truth.effects,
        }
    }
}

impl<'a> AxisEntry<'a> {
    fn new(axis: &'a TrueComponents) -> Self {
        let (kind, unit) = match axis.kind {
            AxisKind::Linear => ("linear", "mm"),
            AxisKind::Rotary => ("rotary", "deg"),
        };
        let positions = axis.positions.iter();
        let directions = axis.directions.as_ref();
        let components = Component::ALL.map(|component| {
            let values = axis.errors.iter().map(|e| e.to_vector()[component.index()]);
            let entry = if component.is_angular() {
                ComponentEntry::Angular {
                    value_arcsec: values.map(|v| tidy(v / ARCSEC)).collect(),
                }
            } else {
                ComponentEntry::Linear {
                    value_um: values.map(|v| tidy(v / MICROMETRE)).collect(),
                }
            };
            (component.name(&axis.name), entry)
        });
        Self {
            name: &axis.name,
            kind,
            unit,
            positions: positions
                .map(|&q| tidy(axis_unit::to_file(axis.kind, q)))
                .collect(),
            direction: directions.map(|all| all.iter().copied().map(sign).collect()),
            reference_point_mm: axis.reference_mm.into(),
            components: InOrder(components.into()),
        }
    }
}

fn location_entry(location: &TrueLocation) -> (String, LocationEntry) {
    let entry = match location.component {
        LocationComponent::Offset(_) => LocationEntry::Offset {
            value_mm: tidy(location.value),
        },
        LocationComponent::Tilt(_) => LocationEntry::Tilt {
            value_arcsec: tidy(location.value / ARCSEC),
        },
    };
    (location.name.clone(), entry)
}

fn sign(direction: Direction) -> i8 {
    match direction {
        Direction::Forward => 1,
        Direction::Backward => -1,
    }
}

/// Rounded to nine decimals of mm, deg, µm or arcsec: far below the rounding of the lengths, and
/// without the digits that unit conversion leaves.
fn tidy(value: f64) -> f64 {
    const PER_UNIT: f64 = 1e9;
    // Adding zero turns -0 into 0.
    (value * PER_UNIT).round() / PER_UNIT + 0.0
}
