//! The lists of `campaign.json`: instrument, targets, stations and runs, from and to the model.

use nalgebra::Point3;
use trueaxis_files::{DocumentError, DocumentProblem, check_name, check_names, index_of};
use trueaxis_kinematics::Machine;

use crate::document::{RunEntry, StationEntry, TargetEntry};
use crate::{Instrument, KnownDeadPath, Run, Station, Target};

/// No standard deviation need be declared, but what is must be possible.
///
/// # Errors
/// A standard deviation that is none, by its field in `campaign.json`.
pub fn check_instrument(instrument: &Instrument) -> Result<(), DocumentError> {
    let of = instrument;
    let (more_than_zero, or_zero) = (false, true);
    let sigmas = [
        ("length_sigma_um", of.length_sigma_um, more_than_zero),
        ("length_sigma_ppm", of.length_sigma_ppm, or_zero),
        ("repeatability_um", of.repeatability_um, or_zero),
        ("reflector_sigma_um", of.reflector_sigma_um, more_than_zero),
        ("scale_sigma_ppm", of.scale_sigma_ppm, more_than_zero),
    ];
    sigmas.into_iter().try_for_each(|(field, sigma, or_zero)| {
        let field = format!("instrument.{field}");
        check_sigma(field, "standard deviation", sigma, "", or_zero)
    })
}

/// Nothing scatters by more, in whatever unit: weights are one over its square.
const LARGEST: f64 = 1e9;

/// Refuses a standard deviation or uncertainty (`what`) that is none; the `unit` in messages begins with a blank.
pub(crate) fn check_sigma(
    field: String,
    what: &str,
    sigma: Option<f64>,
    unit: &str,
    or_zero: bool,
) -> Result<(), DocumentError> {
    let is_none = |sigma: &f64| *sigma < 0.0 || (*sigma == 0.0 && !or_zero) || *sigma > LARGEST;
    sigma.filter(is_none).map_or(Ok(()), |sigma| {
        let (sigma, bound) = match or_zero {
            _ if sigma > LARGEST => (format!("{sigma:e}"), "no more than 1e9"),
            true => (sigma.to_string(), "zero or more"),
            false => (sigma.to_string(), "more than zero"),
        };
        let expected = format!("{bound}; leave it out if it is not known");
        let problem = DocumentProblem::value(format!("a {what} of {sigma}{unit}"), expected);
        Err(problem.in_field(field))
    })
}

/// The targets, with their carriers looked up.
pub(crate) fn targets(
    entries: Vec<TargetEntry>,
    machine: &Machine,
) -> Result<Vec<Target>, DocumentError> {
    check_names("targets", "target", &names(&entries, |entry| &entry.name))?;
    let axes = axis_names(machine);
    let targets = entries.into_iter().enumerate().map(|(i, entry)| {
        let field = |name: &str| format!("targets[{i}].{name}");
        let carrier = entry.carried_by.as_ref();
        let carrier = carrier.map(|name| index_of(field("carried_by"), "axis", name, &axes));
        check_sigma_mm(field("position_sigma_mm"), entry.position_sigma_mm)?;
        Ok(Target {
            carrier: carrier.transpose()?,
            name: entry.name,
            home_mm: Point3::from(entry.position_mm),
            reflector: entry.reflector,
            position_sigma_mm: entry.position_sigma_mm,
        })
    });
    let targets: Vec<Target> = targets.collect::<Result<_, DocumentError>>()?;
    check_reflectors(&targets)?;
    Ok(targets)
}

/// A reflector has a name, and not that of a target which has one of its own: that one is called like the target.
///
/// # Errors
/// A name that is none, by its field in `campaign.json`.
pub fn check_reflectors(targets: &[Target]) -> Result<(), DocumentError> {
    for (i, entry) in targets.iter().enumerate() {
        let Some(name) = &entry.reflector else {
            continue;
        };
        let field = format!("targets[{i}].reflector");
        check_name(&field, name)?;
        let owner = |other: &Target| other.reflector.is_none() && other.name == *name;
        if let Some(owner) = targets.iter().position(owner) {
            let found = format!("`{name}` is a target (targets[{owner}]) that names no reflector");
            let expected = format!(
                "a name of its own; if both have the same reflector, write `\"reflector\": \
                 \"{name}\"` in both"
            );
            return Err(DocumentProblem::value(found, expected).in_field(field));
        }
    }
    Ok(())
}

/// What is declared in mm must be possible.
fn check_sigma_mm(field: String, sigma_mm: Option<f64>) -> Result<(), DocumentError> {
    check_sigma(field, "standard deviation", sigma_mm, " mm", false)
}

pub(crate) fn stations(entries: Vec<StationEntry>) -> Result<Vec<Station>, DocumentError> {
    check_names("stations", "station", &names(&entries, |entry| &entry.name))?;
    let stations = entries.into_iter().enumerate().map(|(i, entry)| {
        Ok(Station {
            dead_path: dead_path(&format!("stations[{i}]"), &entry)?,
            name: entry.name,
            approx_mm: entry.approx_mm.map(Point3::from),
        })
    });
    stations.collect()
}

/// A dead path is known with its uncertainty, or not at all.
fn dead_path(path: &str, entry: &StationEntry) -> Result<Option<KnownDeadPath>, DocumentError> {
    let missing = |name| Err(DocumentProblem::missing(name).in_field(path));
    check_sigma_mm(
        format!("{path}.dead_path_sigma_mm"),
        entry.dead_path_sigma_mm,
    )?;
    match (entry.dead_path_mm, entry.dead_path_sigma_mm) {
        (None, None) => Ok(None),
        (Some(_), None) => missing("dead_path_sigma_mm"),
        (None, Some(_)) => missing("dead_path_mm"),
        (Some(length_mm), Some(sigma_mm)) => Ok(Some(KnownDeadPath {
            length_mm,
            sigma_mm,
        })),
    }
}

/// The runs, with their axes looked up.
pub(crate) fn runs(entries: Vec<RunEntry>, machine: &Machine) -> Result<Vec<Run>, DocumentError> {
    check_names("runs", "run", &names(&entries, |entry| &entry.name))?;
    let axes = axis_names(machine);
    let runs = entries.into_iter().enumerate().map(|(i, entry)| {
        Ok(Run {
            axis: index_of(format!("runs[{i}].axis"), "axis", &entry.axis, &axes)?,
            name: entry.name,
        })
    });
    runs.collect()
}

fn names<T>(entries: &[T], name: impl Fn(&T) -> &String) -> Vec<&str> {
    entries.iter().map(|entry| name(entry).as_str()).collect()
}

/// The entries that [`targets`] reads.
pub(crate) fn targets_to_entries(targets: &[Target], machine: &Machine) -> Vec<TargetEntry> {
    let entries = targets.iter().map(|target| TargetEntry {
        name: target.name.clone(),
        position_mm: target.home_mm.into(),
        carried_by: target.carrier.map(|axis| axis_name(machine, axis)),
        reflector: target.reflector.clone(),
        position_sigma_mm: target.position_sigma_mm,
    });
    entries.collect()
}

/// The entries that [`stations`] reads.
pub(crate) fn stations_to_entries(stations: &[Station]) -> Vec<StationEntry> {
    let entries = stations.iter().map(|station| StationEntry {
        name: station.name.clone(),
        approx_mm: station.approx_mm.map(Into::into),
        dead_path_mm: station.dead_path.map(|known| known.length_mm),
        dead_path_sigma_mm: station.dead_path.map(|known| known.sigma_mm),
    });
    entries.collect()
}

/// The entries that [`runs`] reads.
pub(crate) fn runs_to_entries(runs: &[Run], machine: &Machine) -> Vec<RunEntry> {
    let entries = runs.iter().map(|run| RunEntry {
        name: run.name.clone(),
        axis: axis_name(machine, run.axis),
    });
    entries.collect()
}

/// Name of an axis; empty, which no reading accepts, if there is none.
fn axis_name(machine: &Machine, axis: usize) -> String {
    let axis = machine.axes().get(axis);
    axis.map(|axis| axis.name().to_owned()).unwrap_or_default()
}

/// The names of a machine's axes, for looking them up.
pub(crate) fn axis_names(machine: &Machine) -> Vec<&str> {
    machine.axes().iter().map(|axis| axis.name()).collect()
}
