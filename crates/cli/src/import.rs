//! `trueaxis import`.

pub(crate) mod calibration;

use std::path::PathBuf;

use trueaxis_files::counted;
use trueaxis_import::{Imported, Kind, Map, Skipped};

use crate::args::{ImportArgs, ImportTableArgs, ImportWhat};
use crate::exit::Exit;
use crate::output;
use crate::talk::{notice_all, say, say_all};

/// Rows that the preview shows.
const PREVIEW_ROWS: usize = 5;

pub(crate) fn execute(args: &ImportArgs) -> anyhow::Result<Exit> {
    match &args.what {
        ImportWhat::Calibration(args) => calibration::execute(args),
        ImportWhat::Lengths(args) => table(args, Kind::Lengths, "lengths.csv"),
        ImportWhat::Points(args) => table(args, Kind::Points, "points.csv"),
    }
}

fn table(args: &ImportTableArgs, kind: Kind, default: &str) -> anyhow::Result<Exit> {
    let map = Map::read(&args.map)?;
    let imported = trueaxis_import::read(kind, &args.file, &map)?;
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(default));
    output::write_all_new(&[(&out, imported.text())])?;
    say(&format!(
        "{}: {} in {}; the first ones",
        args.file.display(),
        counted(imported.rows.len(), "row"),
        counted(imported.stops, "stop")
    ));
    say_all(preview(&imported));
    say("skipped");
    say_all(skipped(&imported.skipped));
    notice_all(&imported.notices);
    say(&format!("written: {}", out.display()));
    Ok(Exit::Good)
}

/// The first rows, column below column.
fn preview(imported: &Imported) -> Vec<String> {
    let rows = imported.rows.iter().take(PREVIEW_ROWS);
    let rows: Vec<&Vec<String>> = std::iter::once(&imported.header).chain(rows).collect();
    let width = |column: usize| {
        let widths = rows.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or(0)
    };
    let line = |row: &&Vec<String>| {
        let cells = row.iter().enumerate();
        let cells = cells.map(|(column, cell)| format!("{cell:>0$}", width(column)));
        format!("  {}", cells.collect::<Vec<_>>().join("  "))
    };
    rows.iter().map(line).collect()
}

/// Lines in a row with one reason are one line of it.
fn skipped(skipped: &[Skipped]) -> Vec<String> {
    let together = |a: &Skipped, b: &Skipped| a.line + 1 == b.line && a.reason == b.reason;
    let lines = skipped.chunk_by(together).map(|group| {
        let (first, last) = (group[0].line, group[group.len() - 1].line);
        let reason = &group[0].reason;
        match first == last {
            true => format!("  line {first}: {reason}"),
            false => format!("  lines {first} to {last}: {reason}"),
        }
    });
    let lines: Vec<String> = lines.collect();
    match lines.is_empty() {
        true => vec!["  nothing".to_owned()],
        false => lines,
    }
}
