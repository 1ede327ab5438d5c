//! The result of another system as a calibration, from a file that it wrote for a control.
//!
//! Such files hold component and location errors by their ISO 230-1 names. They are taken as errors, actual minus nominal
//! (right-hand rule), of linear axes at the origin of the reference frame, of rotary ones at the centre in the file or on the
//! nominal axis: as [`crate::export()`] writes them. They say neither by whom nor how well they were measured.

use nalgebra::{DMatrix, Matrix6, Point3, Vector6};
use serde_json::{Value, json};
use trueaxis_campaign::{InputFile, MachineSpec};
use trueaxis_files::round;
use trueaxis_kinematics::{ARCSEC, AxisKind, Component, MICROMETRE, Machine, MotionError};
use trueaxis_predict::{FactoredCovariance, Rows, Unit};

use crate::export::named_errors::{AxisErrors, NamedErrors};
use crate::export::{etalon, in_file, isg, unit};
use crate::{Error, Format};

/// Decimals of µm, ″ and mm: far below anything measurable.
const DECIMALS: i32 = 6;

/// Positions may pass the ends of the travel by so much, mm or rad: rounding.
const ROUNDING: f64 = 1e-6;

/// The standard uncertainties (k = 1) that whoever imports a result declares for all its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeclaredUncertainty {
    /// Of each displacement, µm.
    pub um: f64,
    /// Of each angle, ″; without it the angle that makes as much on half the diagonal of the travels of the linear axes.
    pub arcsec: Option<f64>,
}

/// A file of another system, and what it does not say.
#[derive(Debug, Clone)]
pub struct Import<'a> {
    /// The file with its checksum.
    pub file: InputFile,
    /// Its text.
    pub text: &'a str,
    /// The nominal machine.
    pub machine: &'a Machine,
    /// Its name.
    pub machine_name: &'a str,
    /// How well the values are known, if that is known.
    pub uncertainty: Option<DeclaredUncertainty>,
}

/// A calibration in files.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The format that was found: [`Format::Isg`] or [`Format::Etalon`].
    pub format: Format,
    /// Content of `calibration.json`.
    pub calibration: Value,
    /// That of the results, in the units of `calibration.json`; none without uncertainties.
    pub covariance: Option<FactoredCovariance>,
    /// What a user must know.
    pub notices: Vec<String>,
}

/// Makes a calibration of a file in the format `ISG_CSV` or in the exchange format of Etalon, whichever it is.
///
/// # Errors
/// [`Error::Table`] with the line if the file is damaged or not of this machine, [`Error::NoLever`] for angles of unknown
/// uncertainty.
pub fn import(import: &Import<'_>) -> Result<Imported, Error> {
    let machine = import.machine;
    let (format, errors) = read(&import.file.name, import.text)?;
    let mut axes = errors.of_machine(machine)?;
    for axis in &mut axes {
        check_travel(&errors, machine, axis)?;
        if axis.positions.is_empty() {
            // Location errors alone: the rest is zero on the whole travel.
            axis.positions = machine.axes()[axis.axis].travel().to_vec();
            axis.errors = vec![MotionError::default(); axis.positions.len()];
        }
    }
    let u = import.uncertainty.map(|u| u.in_mm_and_rad(machine));
    let u = u.transpose()?;
    let mut notices = vec![
        "taken as errors by ISO 230-1, actual minus nominal: the file does not say so; compare one measured line (`trueaxis \
         verify`) before you trust it"
            .to_owned(),
    ];
    if !import.text.ends_with(['\n', '\r']) {
        notices.push("the last line of the file has no end: the file may be cut off".to_owned());
    }
    notices.extend(axes.iter().filter_map(|axis| lacks(machine, axis)));
    notices.push(locations_in_words(machine, &axes));
    let (contains, not_known) = statement(u);
    notices.extend(
        not_known
            .iter()
            .map(|what| format!("the uncertainty lacks {what}")),
    );
    let calibration = json!({
        "format": "trueaxis-calibration",
        "version": 1,
        "campaign": format!("imported {}", import.file.name),
        "machine": MachineSpec::of(import.machine_name, machine),
        "method": "imported",
        "stations": [],
        "uncertainty_contains": contains,
        "uncertainty_lacks": not_known,
        "targets": [],
        "axes": axes.iter().map(|axis| axis_json(machine, axis, u)).collect::<Value>(),
        "location_errors": locations_json(machine, &axes, u),
        "notices": notices,
        "traceability": {
            "program": concat!("trueaxis ", env!("CARGO_PKG_VERSION")),
            "inputs": [import.file],
        },
    });
    let steps = axes.iter().map(|axis| axis.positions.len()).sum();
    let of_components = [Unit::Micrometre, Unit::Arcsec].map(|unit| in_unit(unit, u));
    let locations = axes.iter().flat_map(|axis| &axis.locations);
    let of_locations = locations.filter_map(|(c, _)| in_unit(Unit::of_location(*c), u));
    let of_locations = of_locations.collect();
    let covariance = match of_components {
        [Some(um), Some(arcsec)] => Some(covariance(steps, [um, arcsec], of_locations)),
        _ => None,
    };
    Ok(Imported {
        format,
        calibration,
        covariance,
        notices,
    })
}

/// Etalon's files begin with a section.
fn read(file: &str, text: &str) -> Result<(Format, NamedErrors), Error> {
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    let first = lines
        .into_iter()
        .find(|l| !l.is_empty() && !l.starts_with("//"));
    match first.is_some_and(|line| line.starts_with('[')) {
        true => Ok((Format::Etalon, etalon::read::read(file, text)?)),
        false => Ok((Format::Isg, isg::read::read(file, text)?)),
    }
}

fn check_travel(errors: &NamedErrors, machine: &Machine, axis: &AxisErrors) -> Result<(), Error> {
    let geometry = &machine.axes()[axis.axis];
    let [low, high] = geometry.travel();
    let beyond = axis
        .positions
        .iter()
        .find(|q| !(low - ROUNDING..=high + ROUNDING).contains(*q));
    let Some(&position) = beyond else {
        return Ok(());
    };
    let [low, high, position] = [low, high, position].map(|q| in_file(geometry.kind(), q));
    let unit = unit(geometry.kind());
    let found = format!("{} at {position} {unit}", geometry.name());
    let expected = format!(
        "positions within its travel, {low} to {high} {unit}; correct `travel` of the machine, or give that of this file"
    );
    Err(errors.wrong_at(geometry.name(), &found, expected))
}

impl DeclaredUncertainty {
    fn in_mm_and_rad(self, machine: &Machine) -> Result<[f64; 2], Error> {
        let mm = self.um * MICROMETRE;
        let travels = machine.axes().iter().filter_map(|axis| {
            let [low, high] = axis.travel();
            (axis.kind() == AxisKind::Linear).then_some(high - low)
        });
        let lever_mm = 0.5 * travels.map(|travel| travel * travel).sum::<f64>().sqrt();
        match self.arcsec {
            Some(arcsec) => Ok([mm, arcsec * ARCSEC]),
            None if lever_mm > 0.0 => Ok([mm, mm / lever_mm]),
            None => Err(Error::NoLever),
        }
    }
}

/// Standard uncertainties of displacements and angles, mm and rad.
type U = [f64; 2];

fn statement(u: Option<U>) -> (Vec<String>, Vec<String>) {
    let Some([mm, rad]) = u else {
        let none =
            "everything: no uncertainty was given, so that nothing that follows from this calibration has one"
                .to_owned();
        return (Vec::new(), vec![none]);
    };
    let (um, arcsec) = (mm / MICROMETRE, rad / ARCSEC);
    let declared = format!(
        "declared at the import: {um:.3} µm for each displacement, {arcsec:.3}″ for each angle (k = 1)"
    );
    let common = "errors that values have in common, as of scale or temperature: each is taken as independent";
    (vec![declared], vec![common.to_owned()])
}

/// What the file does not say of an axis.
fn lacks(machine: &Machine, axis: &AxisErrors) -> Option<String> {
    let name = machine.axes()[axis.axis].name();
    let missing = Component::ALL.into_iter();
    let missing: Vec<String> = missing
        .filter(|component| !axis.given.contains(component))
        .map(|component| component.name(name))
        .collect();
    let mut said = Vec::new();
    if !missing.is_empty() {
        said.push(format!(
            "not in the file and taken for zero: {}",
            missing.join(", ")
        ));
    }
    if axis.is_interpolated {
        said.push(
            "its errors stand at different positions and are interpolated between them".to_owned(),
        );
    }
    (!said.is_empty()).then(|| format!("axis {name}: {}", said.join("; ")))
}

fn locations_in_words(machine: &Machine, axes: &[AxisErrors]) -> String {
    let names = axes.iter().flat_map(|axis| {
        let name = machine.axes()[axis.axis].name();
        axis.locations
            .iter()
            .map(|(component, _)| component.name(name))
    });
    let names: Vec<String> = names.collect();
    match names.is_empty() {
        true => "no location errors (squareness, places of rotary axes) are in the file: all are taken for zero".to_owned(),
        false => format!("location errors in the file: {}; all others are taken for zero", names.join(", ")),
    }
}

fn axis_json(machine: &Machine, axis: &AxisErrors, u: Option<U>) -> Value {
    let geometry = &machine.axes()[axis.axis];
    let kind = geometry.kind();
    let reference_mm = match kind {
        AxisKind::Linear => Point3::origin(),
        AxisKind::Rotary => axis.centre_mm.unwrap_or(geometry.reference_mm()),
    };
    let reference_mm: [f64; 3] = reference_mm.map(|x| round(x, DECIMALS)).into();
    let component = |component: Component| {
        let unit = Unit::of_component(component);
        let values = axis
            .errors
            .iter()
            .map(|error| error.to_vector()[component.index()]);
        let values: Vec<f64> = values.map(|x| round(x / unit.size(), DECIMALS)).collect();
        let mut curve = json!({ format!("value_{}", unit.suffix()): values });
        if let Some(u) = in_unit(unit, u) {
            curve[format!("u_{}", unit.suffix())] = json!(vec![u; values.len()]);
        }
        (component.name(geometry.name()), curve)
    };
    let positions = axis.positions.iter().map(|&q| in_file(kind, q));
    json!({
        "name": geometry.name(),
        "kind": kind.name(),
        "unit": kind.position_unit(),
        "positions": positions.collect::<Value>(),
        "reference_point_mm": reference_mm,
        "components": Component::ALL.into_iter().map(component).collect::<Value>(),
    })
}

fn locations_json(machine: &Machine, axes: &[AxisErrors], u: Option<U>) -> Value {
    let entries = axes.iter().flat_map(|axis| {
        let name = machine.axes()[axis.axis].name();
        axis.locations.iter().map(move |(component, value)| {
            let unit = Unit::of_location(*component);
            let value = round(value / unit.size(), DECIMALS);
            let mut entry = json!({ format!("value_{}", unit.suffix()): value });
            if let Some(u) = in_unit(unit, u) {
                entry[format!("u_{}", unit.suffix())] = json!(u);
            }
            (component.name(name), entry)
        })
    });
    entries.collect()
}

/// The standard uncertainty of values in a unit.
fn in_unit(unit: Unit, u: Option<U>) -> Option<f64> {
    u.map(|[mm, rad]| match unit {
        Unit::Micrometre => round(mm / MICROMETRE, DECIMALS),
        Unit::Arcsec => round(rad / ARCSEC, DECIMALS),
        Unit::Millimetre => round(mm, 2 * DECIMALS),
    })
}

/// Each result has its own uncertainty: the same block for each step, and a column for each location error.
fn covariance(steps: usize, [um, arcsec]: [f64; 2], of_locations: Vec<f64>) -> FactoredCovariance {
    let u = Vector6::new(um, um, um, arcsec, arcsec, arcsec);
    let columns = of_locations.len();
    let of_steps = DMatrix::zeros(6 * steps, columns);
    let of_locations = DMatrix::from_diagonal(&of_locations.into());
    FactoredCovariance::new(
        vec![Matrix6::from_diagonal(&u.component_mul(&u)); steps],
        vec![Rows::new(0, &of_steps), Rows::new(6 * steps, &of_locations)],
        &DMatrix::identity(columns, columns),
    )
}
