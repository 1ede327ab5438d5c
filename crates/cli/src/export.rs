//! `trueaxis export`.

use std::path::{Path, PathBuf};

use trueaxis_calibrate::CalibratedMachine;
use trueaxis_compensate::{Announcement, Error, ExportedFile, Format, Request, export};
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};

use crate::args::ExportArgs;
use crate::exit::Exit;
use crate::output;
use crate::predict::source;
use crate::talk::{notice, say};

pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Exit> {
    let machine = CalibratedMachine::read(&args.calibration)?;
    let format = args.format;
    let axis = args.axis.as_deref().map(|name| index(&machine, name));
    let at = args.at.unwrap_or(machine.reference_point_mm());
    let old = match &args.onto {
        None => Vec::new(),
        Some(path) => old_tables(&machine, format, path)?,
    };
    let tables = export(
        format,
        &Request {
            machine: &machine,
            at,
            axis: axis.transpose()?,
            step: args.step,
            onto: &old,
        },
    )?;
    for line in source(&machine) {
        say(&line);
    }
    for line in announced(&machine, &tables.announcement) {
        say(&line);
    }
    tables
        .notes
        .iter()
        .for_each(|note| say(&format!("  {note}")));
    if tables.is_experimental {
        notice(&format!(
            "{} is experimental: not all of its rule is public; check it with one measured line before you trust it",
            format.name()
        ));
    }
    if args.at.is_none() {
        let [x, y, z]: [f64; 3] = at.coords.into();
        notice(&format!(
            "no --at: the lines go through the reference point ({x}, {y}, {z}) mm, not through where the machine works"
        ));
    }
    if old.is_empty() {
        notice(
            "a control that compensated while it was measured must keep doing so: add these tables to the old ones (--onto)",
        );
    }
    let folder = output::folder(args.out.as_deref(), &machine.campaign)?;
    for file in &tables.files {
        let path = folder.join(&file.name);
        output::write(&path, file.text.as_bytes())?;
        say(&format!("written: {}", path.display()));
    }
    Ok(Exit::Good)
}

/// Old tables that cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OldTablesError {
    /// The operating system refuses.
    #[error("{} cannot be read", path.display())]
    Unreadable {
        path: PathBuf,
        source: std::io::Error,
    },
    /// No table is in it.
    #[error("{} has none of {names}; --onto wants the folder of the old tables, or a file", folder.display())]
    Nothing { folder: PathBuf, names: String },
}

/// A file, or those in a folder that have the names of the format.
fn old_tables(
    machine: &CalibratedMachine,
    format: Format,
    path: &Path,
) -> anyhow::Result<Vec<ExportedFile>> {
    let axes = machine.machine().axes().iter().map(|axis| axis.name());
    let names = format.old_files(axes)?;
    let files: Vec<(String, PathBuf)> = match path.file_name() {
        Some(name) if path.is_file() => {
            vec![(name.to_string_lossy().into_owned(), path.to_owned())]
        }
        _ => names
            .iter()
            .map(|name| (name.clone(), path.join(name)))
            .collect(),
    };
    let mut old = Vec::new();
    for (name, path) in files {
        match std::fs::read_to_string(&path) {
            Ok(text) => old.push(ExportedFile { name, text }),
            Err(source) if source.kind() == std::io::ErrorKind::NotFound => {}
            Err(source) => return Err(OldTablesError::Unreadable { path, source }.into()),
        }
    }
    match old.is_empty() {
        true => Err(OldTablesError::Nothing {
            folder: path.to_owned(),
            names: names.join(", "),
        }
        .into()),
        false => Ok(old),
    }
}

fn index(machine: &CalibratedMachine, name: &str) -> Result<usize, Error> {
    let axes = machine.machine().axes();
    machine.machine().axis_index(name).ok_or_else(|| {
        let measured = (0..axes.len()).filter(|&axis| !machine.steps(axis).is_empty());
        let names: Vec<&str> = measured.map(|axis| axes[axis].name()).collect();
        Error::NoSuchAxis {
            axis: name.to_owned(),
            measured: names.join(", "),
        }
    })
}

/// What the tables can take away and what not, of the errors as calibrated.
fn announced(machine: &CalibratedMachine, announcement: &Announcement) -> Vec<String> {
    let mut lines = vec!["of the errors as calibrated, the tables leave".to_owned()];
    for line in &announcement.lines {
        let axis = &machine.machine().axes()[line.axis];
        let (unit, symbol) = match axis.kind() {
            AxisKind::Linear => (MICROMETRE, "µm"),
            AxisKind::Rotary => (ARCSEC, "″"),
        };
        lines.push(format!(
            "  positioning of {}, range on its line   {:.2} -> {:.2} {symbol}",
            axis.name(),
            line.before / unit,
            line.after / unit
        ));
    }
    let (before, after) = (&announcement.before, &announcement.after);
    for (what, before, after, unit, symbol) in [
        (
            "volumetric error, rms",
            before.rms_mm,
            after.rms_mm,
            MICROMETRE,
            "µm",
        ),
        (
            "volumetric error, largest",
            before.max_mm,
            after.max_mm,
            MICROMETRE,
            "µm",
        ),
        (
            "rotation of the tool, largest",
            before.rotation_rad,
            after.rotation_rad,
            ARCSEC,
            "″",
        ),
    ] {
        lines.push(format!(
            "  {what:36} {:.2} -> {:.2} {symbol}",
            before / unit,
            after / unit
        ));
    }
    lines
}
