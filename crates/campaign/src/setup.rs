//! The lists of `campaign.json`: instrument, targets, stations and runs, from and to the model.

use nalgebra::Point3;
use trueaxis_files::{DocumentError, DocumentProblem, check_names, index_of};
use trueaxis_kinematics::Machine;

use crate::document::{RunEntry, StationEntry, TargetEntry};
use crate::{Instrument, Run, Station, Target};

/// Of the declared accuracy none is needed, but what is given must be possible.
pub(crate) fn check_instrument(instrument: &Instrument) -> Result<(), DocumentError> {
    let sigmas = [
        (
            "length_sigma_um",
            instrument.length_sigma_um,
            "more than zero",
        ),
        (
            "length_sigma_ppm",
            instrument.length_sigma_ppm,
            "zero or more",
        ),
        (
            "repeatability_um",
            instrument.repeatability_um,
            "zero or more",
        ),
    ];
    for (field, sigma, least) in sigmas {
        let zero_too = least == "zero or more";
        if let Some(sigma) = sigma.filter(|&sigma| sigma < 0.0 || (sigma == 0.0 && !zero_too)) {
            let found = format!("a standard deviation of {sigma}");
            let expected = format!("{least}; leave it out if it is not known");
            let problem = DocumentProblem::value(found, expected);
            return Err(problem.in_field(format!("instrument.{field}")));
        }
    }
    Ok(())
}

/// The targets, with their carriers looked up.
pub(crate) fn targets(
    entries: Vec<TargetEntry>,
    machine: &Machine,
) -> Result<Vec<Target>, DocumentError> {
    check_names("targets", "target", &names(&entries, |entry| &entry.name))?;
    let axes = axis_names(machine);
    let targets = entries.into_iter().enumerate().map(|(i, entry)| {
        let field = format!("targets[{i}].carried_by");
        Ok(Target {
            carrier: index_of(field, "axis", &entry.carried_by, &axes)?,
            name: entry.name,
            home_mm: Point3::from(entry.position_mm),
        })
    });
    targets.collect()
}

/// The stations.
pub(crate) fn stations(entries: Vec<StationEntry>) -> Result<Vec<Station>, DocumentError> {
    check_names("stations", "station", &names(&entries, |entry| &entry.name))?;
    let stations = entries.into_iter().map(|entry| Station {
        name: entry.name,
        approx_mm: entry.approx_mm.map(Point3::from),
    });
    Ok(stations.collect())
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
        carried_by: axis_name(machine, target.carrier),
    });
    entries.collect()
}

/// The entries that [`stations`] reads.
pub(crate) fn stations_to_entries(stations: &[Station]) -> Vec<StationEntry> {
    let entries = stations.iter().map(|station| StationEntry {
        name: station.name.clone(),
        approx_mm: station.approx_mm.map(Into::into),
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
