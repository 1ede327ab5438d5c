//! `trueaxis export`.

use std::path::{Path, PathBuf};

use trueaxis_compensate::{Announcement, Error, ExportedFile, Format, Request, Sizes, export};
use trueaxis_files::point_mm;
use trueaxis_kinematics::{ARCSEC, AxisKind, MICROMETRE};
use trueaxis_predict::CalibratedMachine;

use crate::args::ExportArgs;
use crate::exit::Exit;
use crate::given_file::Unreadable;
use crate::output::Results;
use crate::predict::source;
use crate::talk::{notice, say_all};

pub(crate) fn execute(args: &ExportArgs) -> anyhow::Result<Exit> {
    let machine = CalibratedMachine::read(&args.calibration)?;
    let format = args.format;
    let axis = args.axis.as_deref().map(|name| index(&machine, name));
    let at = args.at.unwrap_or(machine.reference_point_mm());
    let (old, said_of_old) = match &args.onto {
        None => (Vec::new(), NONE_GIVEN.to_owned()),
        Some(path) => old_tables(&machine, format, path)?,
    };
    let request = Request {
        format,
        machine: &machine,
        at,
        axis: axis.transpose()?,
        step: args.step,
        sign: args.sign,
        levers: args.levers,
        onto: &old,
    };
    let folder = args.onto.as_deref().map_or(Path::new(""), folder_of);
    let tables = export(&request).map_err(|error| in_folder(error, folder))?;
    let mut results = Results::new(args.out.as_deref(), &machine.campaign)?;
    // Made again, the tables would be added to themselves.
    if args.onto.is_some() && are_one(folder, &results.folder) {
        return Err(OntoItself {
            folder: folder.to_owned(),
        }
        .into());
    }
    say_all(source(&machine));
    say_all(announced(&machine, &tables.announcement));
    say_all(tables.notes.iter().map(|note| format!("  {note}")));
    if tables.is_experimental {
        notice(&format!(
            "{} is experimental: not all of its rule is public; check it with one measured line before you trust it",
            format.name()
        ));
    }
    if args.at.is_none() {
        notice(&format!(
            "no --at: the lines go through the reference point {}, not through where the machine works",
            point_mm(at.into())
        ));
    }
    if format.old_files(machine.machine()).is_ok() {
        notice(&said_of_old);
    } else {
        notice(
            "these tables are valid only if the control's own correction was off while the machine was measured",
        );
    }
    let (before, after) = (&tables.announcement.before, &tables.announcement.after);
    if after.rms_mm > before.rms_mm || after.max_mm > before.max_mm {
        notice(
            "with these tables the volumetric error, rms or largest, is larger: errors that they leave, as those of rotary axes, partly cancelled \
             those that they take away; take a format that holds all (isg, etalon), or the tables of single axes (--axis)",
        );
    }
    for file in &tables.files {
        results.write(&file.name, file.text.as_bytes())?;
    }
    results.end(None)?;
    Ok(Exit::Good)
}

/// Whether two paths lead to the same folder.
fn are_one(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(std::fs::canonicalize);
    matches!((a, b), (Ok(a), Ok(b)) if a == b)
}

/// The old tables would be overwritten by what was added to them.
#[derive(Debug, thiserror::Error)]
#[error("the new tables would take the place of the old ones in {}, and making them again would add to them again; give another --out", folder.display())]
pub(crate) struct OntoItself {
    folder: PathBuf,
}

/// A folder without old tables.
#[derive(Debug, thiserror::Error)]
#[error("{} has none of {names}; {ONTO}", folder.display())]
pub(crate) struct NoOldTables {
    folder: PathBuf,
    names: String,
}

const NONE_GIVEN: &str = "a control that compensated while it was measured must keep doing so: add these tables to the old ones (--onto)";

const ONTO: &str = "--onto wants the folder of the old tables, or a file";

/// A file, or those in a folder that have the names of the format; and which these are, with what else is in the folder.
fn old_tables(
    machine: &CalibratedMachine,
    format: Format,
    path: &Path,
) -> anyhow::Result<(Vec<ExportedFile>, String)> {
    let unreadable = Unreadable::at(path, ONTO);
    let expected = format.old_files(machine.machine())?;
    let (names, others) = match path.file_name() {
        Some(name) if path.is_file() => (vec![name.to_string_lossy().into_owned()], Vec::new()),
        _ => {
            let all = names_in(path).map_err(unreadable)?;
            all.into_iter()
                .partition(|name| format.is_like_an_old_file(name))
        }
    };
    if names.is_empty() {
        return Err(NoOldTables {
            folder: path.to_owned(),
            names: expected.join(", "),
        }
        .into());
    }
    let mut old = Vec::new();
    for name in names {
        let path = folder_of(path).join(&name);
        let text = std::fs::read_to_string(&path).map_err(Unreadable::at(&path, ONTO))?;
        old.push(ExportedFile { name, text });
    }
    let read: Vec<&str> = old.iter().map(|file| file.name.as_str()).collect();
    let mut said = format!(
        "the new tables contain what the targets saw of the old {}",
        read.join(", ")
    );
    // One file of a format may have any name.
    let (given, not_given): (Vec<&str>, Vec<&str>) = expected
        .iter()
        .map(String::as_str)
        .partition(|name| read.contains(name));
    if !given.is_empty() && !not_given.is_empty() {
        said.push_str(&format!("; not given: {}", not_given.join(", ")));
    }
    for file in old.iter().filter(|file| !file.text.ends_with('\n')) {
        let name = &file.name;
        said += &format!("; the last line of {name} has no end: the file may be cut off");
    }
    if !others.is_empty() {
        said.push_str(&format!("; not read: {}", others.join(", ")));
    }
    Ok((old, said))
}

/// The folder that is given, or that of the file.
fn folder_of(path: &Path) -> &Path {
    match path.is_file() {
        true => path.parent().unwrap_or(path),
        false => path,
    }
}

/// A line of a table that is wrong, with the path of its file.
pub(crate) fn in_folder(mut error: Error, folder: &Path) -> Error {
    if let Error::Table { file, .. } = &mut error {
        *file = folder.join(&*file).display().to_string();
    }
    error
}

/// The files of a folder in the order of their names.
fn names_in(folder: &Path) -> std::io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        if entry.path().is_file() {
            names.push(entry.file_name().to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
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
    let mut line = |what: &str, of: fn(&Sizes) -> f64, unit: f64, symbol: &str| {
        let (before, after) = (of(before) / unit, of(after) / unit);
        lines.push(format!("  {what:36} {before:.2} -> {after:.2} {symbol}"));
    };
    line("volumetric error, rms", |s| s.rms_mm, MICROMETRE, "µm");
    line("volumetric error, largest", |s| s.max_mm, MICROMETRE, "µm");
    line(
        "rotation of the tool, largest",
        |s| s.rotation_max_rad,
        ARCSEC,
        "″",
    );
    lines
}
