//! Reading the calibrated machine from `calibration.json` and `covariance.npz`.
//!
//! What a prediction does not need is not looked at.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::{Point3, Vector6};
use serde::Deserialize;
use trueaxis_campaign::{Direction, MachineSpec};
use trueaxis_effects::GivenEffect;
use trueaxis_files::{DocumentError, DocumentProblem, Format, field_line, read_bytes};
use trueaxis_kinematics::{AxisKind, Component, LocationError, Machine, MotionError};

use crate::calibrated_machine::{CalibratedMachine, MeasuredAxis};
use crate::factored_covariance::FactoredCovariance;
use crate::files::read_error::{CovarianceProblem, ReadError};
use crate::interpolation::Node;
use crate::output::Unit;

#[derive(Deserialize)]
#[serde(expecting = "an object: the calibration")]
struct Document {
    campaign: String,
    machine: MachineSpec,
    stations: Vec<serde::de::IgnoredAny>,
    axes: Vec<AxisEntry>,
    location_errors: BTreeMap<String, LocationEntry>,
    #[serde(default)]
    effects_taken_out: Vec<GivenEffect>,
}

#[derive(Deserialize)]
#[serde(expecting = "an object: an axis")]
struct AxisEntry {
    name: String,
    positions: Vec<f64>,
    direction: Option<Vec<i8>>,
    reference_point_mm: [f64; 3],
    #[serde(default)]
    parked: BTreeMap<String, Option<f64>>,
    components: BTreeMap<String, CurveEntry>,
}

#[derive(Deserialize)]
#[serde(expecting = "an object: an error curve")]
struct CurveEntry {
    #[serde(alias = "value_arcsec")]
    value_um: Vec<f64>,
    #[serde(alias = "u_arcsec")]
    u_um: Option<Vec<f64>>,
    dof: Option<f64>,
}

#[derive(Deserialize)]
#[serde(expecting = "an object: a location error")]
struct LocationEntry {
    #[serde(alias = "value_arcsec")]
    value_mm: f64,
    #[serde(alias = "u_arcsec")]
    u_mm: Option<f64>,
    dof: Option<f64>,
}

impl Document {
    /// Whether any error has a standard uncertainty; then all must. Imported calibrations may have none.
    fn has_uncertainties(&self) -> bool {
        let curves = self.axes.iter().flat_map(|axis| axis.components.values());
        let of_locations = self.location_errors.values().any(|l| l.u_mm.is_some());
        curves.into_iter().any(|curve| curve.u_um.is_some()) || of_locations
    }
}

impl CalibratedMachine {
    /// The format of `calibration.json`.
    pub const FORMAT: Format = Format {
        name: "trueaxis-calibration",
        version: 1,
        noun: "a calibration",
    };

    /// Reads `calibration.json`, and, if its errors have uncertainties, `covariance.npz` beside it.
    pub fn read(path: &Path) -> Result<Self, ReadError> {
        let bytes = read_file(path, "give the path of a calibration.json")?;
        let text = String::from_utf8_lossy(&bytes);
        let document: Document = Self::FORMAT.read(&text, Some(path))?;
        let machine = document.machine.build().map_err(|mut error| {
            error.place.file = Some(path.to_owned());
            error
        })?;
        let read = Measured::new(&document, machine).map_err(|mut error| {
            if let Some(field) = error.place.field_path() {
                error.place.line = Some(field_line(&text, field));
            }
            error.place.file = Some(path.to_owned());
            error
        })?;
        let has_uncertainties = document.has_uncertainties();
        let factors = match has_uncertainties {
            true => read.factors_beside(path, document.stations.len())?,
            false => FactoredCovariance::zero(read.nodes_of_all(), read.results.len()),
        };
        Ok(Self {
            name: document.machine.name,
            campaign: document.campaign,
            effects_taken_out: document.effects_taken_out,
            parked: read.parked,
            has_uncertainties,
            dof: read.dof,
            ..Self::new(read.machine, read.axes, factors)
        })
    }
}

/// What `calibration.json` says of the errors.
struct Measured {
    machine: Machine,
    /// In the order of the file.
    axes: Vec<MeasuredAxis>,
    /// Name, unit and stated standard uncertainty (in that unit) of each result; zero where none has one.
    results: Vec<(String, Unit, f64)>,
    /// For each of these axes where the others stood, mm or rad.
    parked: BTreeMap<usize, Vec<Option<f64>>>,
    has_uncertainties: bool,
    dof: f64,
}

impl Measured {
    fn new(document: &Document, mut machine: Machine) -> Result<Self, DocumentError> {
        let mut measured = Self {
            machine: machine.clone(),
            axes: Vec::new(),
            results: Vec::new(),
            parked: BTreeMap::new(),
            has_uncertainties: document.has_uncertainties(),
            dof: f64::INFINITY,
        };
        let names: Vec<String> = machine.axes().iter().map(|a| a.name().to_owned()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let index_of =
            |field: String, name: &str| trueaxis_files::index_of(field, "axis", name, &names);
        for (i, entry) in document.axes.iter().enumerate() {
            let field = format!("axes[{i}]");
            let index = index_of(format!("{field}.name"), &entry.name)?;
            let mut parked = vec![Some(0.0); names.len()];
            for (name, &position) in &entry.parked {
                let other = index_of(format!("{field}.parked"), name)?;
                let kind = machine.axes()[other].kind();
                parked[other] = position.map(|position| kind.position_from_file(position));
            }
            measured.parked.insert(index, parked);
            let reference_mm = Point3::from(entry.reference_point_mm);
            machine = machine.with_axes(|other, axis| match other == index {
                true => axis.with_reference(reference_mm),
                false => axis,
            });
            let (nodes, errors) = measured.nodes(entry, machine.axes()[index].kind(), &field)?;
            measured.axes.push(MeasuredAxis {
                axis: index,
                nodes,
                errors,
                location: LocationError::default(),
                reported: Vec::new(),
            });
        }
        measured.machine = machine;
        measured.read_locations(&document.location_errors)?;
        Ok(measured)
    }

    fn nodes(
        &mut self,
        entry: &AxisEntry,
        kind: AxisKind,
        field: &str,
    ) -> Result<(Vec<Node>, Vec<MotionError>), DocumentError> {
        let steps = entry.positions.len();
        let require = |name: &str, found: usize| match found == steps {
            true => Ok(()),
            false => {
                let found = format!("{found} entries");
                let problem =
                    DocumentProblem::value(found, format!("{steps}, one for each of `positions`"));
                Err(problem.in_field(format!("{field}.{name}")))
            }
        };
        if let Some(directions) = &entry.direction {
            require("direction", directions.len())?;
        }
        let mut curves = Vec::new();
        for component in Component::ALL {
            let name = component.name(&entry.name);
            let Some(curve) = entry.components.get(&name) else {
                let problem = DocumentProblem::missing(&name);
                return Err(problem.in_field(format!("{field}.components")));
            };
            require(&format!("components.{name}"), curve.value_um.len())?;
            let unit = Unit::of_component(component);
            let u = match &curve.u_um {
                Some(u) => u.clone(),
                None if !self.has_uncertainties => vec![0.0; steps],
                None => return Err(no_u(unit, format!("{field}.components.{name}"))),
            };
            require(&format!("components.{name}"), u.len())?;
            self.dof = self.dof.min(curve.dof.unwrap_or(f64::INFINITY));
            curves.push((name, unit, curve, u));
        }
        let of_step = |k: usize| {
            let values = curves
                .iter()
                .map(|(_, unit, curve, _)| curve.value_um[k] * unit.size());
            let node = Node {
                position: kind.position_from_file(entry.positions[k]),
                direction: entry.direction.as_ref().map(|sides| match sides[k] > 0 {
                    true => Direction::Forward,
                    false => Direction::Backward,
                }),
            };
            (
                node,
                MotionError::from_vector(&Vector6::from_iterator(values)),
            )
        };
        let nodes = (0..steps).map(of_step).unzip();
        for k in 0..steps {
            for (name, unit, _, u) in &curves {
                let name = format!("{name} at {}", entry.positions[k]);
                self.results.push((name, *unit, u[k]));
            }
        }
        Ok(nodes)
    }

    /// The location errors by their names, in the order of the results.
    fn read_locations(
        &mut self,
        entries: &BTreeMap<String, LocationEntry>,
    ) -> Result<(), DocumentError> {
        let mut known = Vec::new();
        for axis in &mut self.axes {
            let geometry = &self.machine.axes()[axis.axis];
            for component in geometry.location_components() {
                let name = component.name(geometry.name());
                known.push(name.clone());
                let Some(entry) = entries.get(&name) else {
                    continue;
                };
                let unit = Unit::of_location(component);
                let value = entry.value_mm * unit.size();
                *component.of_mut(&mut axis.location) = value;
                axis.reported.push(component);
                let u = match entry.u_mm {
                    None if self.has_uncertainties => {
                        return Err(no_u(unit, format!("location_errors.{name}")));
                    }
                    u => u.unwrap_or(0.0),
                };
                self.results.push((name, unit, u));
                self.dof = self.dof.min(entry.dof.unwrap_or(f64::INFINITY));
            }
            geometry.complete_tilt(&mut axis.location);
        }
        let unknown = entries.keys().find(|name| !known.contains(name));
        match unknown {
            None => Ok(()),
            Some(name) => {
                let problem = DocumentProblem::unknown_name("location error", name, &known);
                Err(problem.in_field(format!("location_errors.{name}")))
            }
        }
    }

    fn nodes_of_all(&self) -> usize {
        self.axes.iter().map(|axis| axis.nodes.len()).sum()
    }

    /// The covariance in the file beside `calibration`.
    fn factors_beside(
        &self,
        calibration: &Path,
        stations: usize,
    ) -> Result<FactoredCovariance, ReadError> {
        let path = calibration.with_file_name(FactoredCovariance::FILE);
        let hint =
            "it belongs beside calibration.json; copy it there, or calibrate the campaign again";
        let bytes = read_file(&path, hint)?;
        let factors = self.factors(&bytes, stations);
        factors.map_err(|problem| ReadError::Covariance { path, problem })
    }

    /// The covariance, which must be that of these results.
    fn factors(
        &self,
        bytes: &[u8],
        stations: usize,
    ) -> Result<FactoredCovariance, CovarianceProblem> {
        let nodes = self.nodes_of_all();
        let count = self.results.len() + 4 * stations;
        let in_file = FactoredCovariance::from_npz(bytes, nodes, count)?;
        for (i, (name, unit, expected)) in self.results.iter().enumerate() {
            let u = in_file.u(&[(i, 1.0)]);
            if (u - expected).abs() > SAME_U * expected + ROUNDED_U {
                return Err(CovarianceProblem::OtherUncertainty {
                    result: format!("{name} ({})", unit.suffix()),
                    found: u,
                    expected: *expected,
                });
            }
        }
        let units = self.results.iter().map(|(_, unit, _)| unit.size());
        let units: Vec<f64> = units
            .chain(std::iter::repeat_n(1.0, 4 * stations))
            .collect();
        Ok(in_file.multiplied(&units))
    }
}

/// Either all errors have standard uncertainties or none has.
fn no_u(unit: Unit, field: String) -> DocumentError {
    DocumentProblem::missing(&format!("u_{}", unit.suffix())).in_field(field)
}

/// Standard uncertainties of one result that differ by no more are the same: relative, and what `calibration.json`
/// rounds (µm, ″ or mm).
const SAME_U: f64 = 1e-4;
const ROUNDED_U: f64 = 1e-5;
fn read_file(path: &Path, hint: &str) -> Result<Vec<u8>, ReadError> {
    read_bytes(path, hint).map_err(|problem| ReadError::File {
        path: path.to_owned(),
        problem,
    })
}
