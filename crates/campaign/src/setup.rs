//! The lists of `campaign.json`: instrument, targets, stations and runs, from and to the model.

use std::path::Path;

use nalgebra::Point3;
use trueaxis_kinematics::Machine;

use crate::document::{InstrumentEntry, RunEntry, StationEntry, TargetEntry};
use crate::names::Names;
use crate::{Error, Instrument, Place, Run, Station, Target};

/// The declared accuracy; none of it is needed, but what is given must be possible.
pub(crate) fn instrument(file: &Path, entry: InstrumentEntry) -> Result<Instrument, Error> {
    let check = |field: &str, value: Option<f64>, positive: bool| match value {
        Some(sigma) if sigma < 0.0 || (positive && sigma == 0.0) => Err(Error::Value {
            place: Place::field(file, format!("instrument.{field}")),
            found: format!("a standard deviation of {sigma}"),
            expected: if positive {
                "more than zero; leave it out if it is not known".to_owned()
            } else {
                "zero or more; leave it out if it is not known".to_owned()
            },
        }),
        _ => Ok(()),
    };
    check("length_sigma_um", entry.length_sigma_um, true)?;
    check("length_sigma_ppm", entry.length_sigma_ppm, false)?;
    check("repeatability_um", entry.repeatability_um, false)?;
    Ok(Instrument {
        name: entry.name,
        length_sigma_um: entry.length_sigma_um,
        length_sigma_ppm: entry.length_sigma_ppm,
        repeatability_um: entry.repeatability_um,
    })
}

/// The targets, with their carriers looked up.
pub(crate) fn targets(
    file: &Path,
    entries: Vec<TargetEntry>,
    machine: &Machine,
) -> Result<Vec<Target>, Error> {
    Names::new("target", entries.iter().map(|entry| entry.name.as_str())).check(file, "targets")?;
    let mut axes = axis_names(machine);
    entries
        .into_iter()
        .enumerate()
        .map(|(i, entry)| {
            let path = format!("targets[{i}].carried_by");
            let carrier = axes.in_field(&entry.carried_by, file, &path)?;
            Ok(Target {
                name: entry.name,
                home_mm: Point3::from(entry.position_mm),
                carrier,
            })
        })
        .collect()
}

/// The stations.
pub(crate) fn stations(file: &Path, entries: Vec<StationEntry>) -> Result<Vec<Station>, Error> {
    Names::new("station", entries.iter().map(|entry| entry.name.as_str()))
        .check(file, "stations")?;
    let stations = entries.into_iter().map(|entry| Station {
        name: entry.name,
        approx_mm: entry.approx_mm.map(Point3::from),
    });
    Ok(stations.collect())
}

/// The runs, with their axes looked up.
pub(crate) fn runs(
    file: &Path,
    entries: Vec<RunEntry>,
    machine: &Machine,
) -> Result<Vec<Run>, Error> {
    Names::new("run", entries.iter().map(|entry| entry.name.as_str())).check(file, "runs")?;
    let mut axes = axis_names(machine);
    entries
        .into_iter()
        .enumerate()
        .map(|(i, entry)| {
            let axis = axes.in_field(&entry.axis, file, &format!("runs[{i}].axis"))?;
            Ok(Run {
                name: entry.name,
                axis,
            })
        })
        .collect()
}

/// The entry that [`instrument`] reads; none if nothing is declared.
pub(crate) fn instrument_to_entry(instrument: &Instrument) -> Option<InstrumentEntry> {
    (*instrument != Instrument::default()).then(|| InstrumentEntry {
        name: instrument.name.clone(),
        length_sigma_um: instrument.length_sigma_um,
        length_sigma_ppm: instrument.length_sigma_ppm,
        repeatability_um: instrument.repeatability_um,
    })
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
pub(crate) fn axis_names(machine: &Machine) -> Names<'_> {
    Names::new("axis", machine.axes().iter().map(|axis| axis.name()))
}
