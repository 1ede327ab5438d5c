//! The way from an export to a table.

use std::collections::HashSet;
use std::path::Path;

use trueaxis_files::{Part, Place, csv_cell, read_bytes};

use crate::cells::cells;
use crate::clock::Clock;
use crate::columns::{Columns, Names, Source};
use crate::decode::decode;
use crate::map::Map;
use crate::reader::{Fault, Reader};
use crate::stops::{self, Row, Visit};
use crate::{Error, Problem, path};

/// Which table an export becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `lengths.csv`.
    Lengths,
    /// `points.csv`.
    Points,
}

/// The rows of a table, and what was left out.
#[derive(Debug, Clone)]
pub struct Imported {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells in mm, degrees and s, in the order of the export.
    pub rows: Vec<Vec<String>>,
    /// Lines that are no row of the table, in their order.
    pub skipped: Vec<Skipped>,
    /// Number of stops: visits of the machine.
    pub stops: usize,
    /// What was not read but follows from the order of the rows.
    pub notices: Vec<String>,
}

/// A line of the export that is no row of the table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// Its number, from 1.
    pub line: usize,
    /// Why.
    pub reason: String,
}

impl Imported {
    /// The table as the text of a CSV file.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for row in std::iter::once(&self.header).chain(&self.rows) {
            let cells: Vec<_> = row.iter().map(|cell| csv_cell(cell)).collect();
            text.push_str(&cells.join(","));
            text.push('\n');
        }
        text
    }
}

/// The bytes of a file.
///
/// # Errors
/// If there is no such file or it cannot be read; `hint` says what to give instead.
pub(crate) fn bytes(file: &Path, hint: &str) -> Result<Vec<u8>, Error> {
    read_bytes(file, hint).map_err(|problem| Problem::File(problem).at(Place::file(file)))
}

/// The table of that kind from the export in `file`.
///
/// # Errors
/// If the file cannot be read, and those of [`import`].
pub fn read(kind: Kind, file: &Path, map: &Map) -> Result<Imported, Error> {
    let bytes = bytes(file, "give the file that the instrument's program exported")?;
    import(kind, &bytes, Some(file), map)
}

/// The table of that kind from the bytes of an export; `file` is only named.
///
/// # Errors
/// What is wrong with the map, or the first row that is not understood.
pub fn import(kind: Kind, bytes: &[u8], file: Option<&Path>, map: &Map) -> Result<Imported, Error> {
    let mut place = Place {
        file: file.map(Path::to_owned),
        ..Place::default()
    };
    let text = decode(bytes).map_err(|problem| problem.at(Box::new(place.clone())))?;
    let planned = path::stops(&map.stops.path)
        .map_err(|(index, problem)| map.refused(&format!("stops.path[{index}]"), problem))?;
    let (separator, separator_words) = map.separator()?;

    // Which lines are rows? Spreadsheets end a table with lines of separators.
    let is_blank = |c: char| c.is_whitespace() || c == separator || c == '"';
    let mut skipped = Vec::new();
    let mut names: Option<(usize, Vec<String>)> = None;
    let mut lines = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let comment = map
            .comment
            .iter()
            .find(|mark| !mark.is_empty() && text.trim_start().starts_with(mark.as_str()));
        let reason = match comment {
            _ if line <= map.skip_lines => "before the table (skip_lines)".to_owned(),
            _ if text.chars().all(is_blank) => "blank".to_owned(),
            Some(mark) => format!("comment ({mark})"),
            None if names.is_none() && map.column_names != Some(false) => {
                names = Some((line, cells(text, separator)));
                "names of the columns".to_owned()
            }
            None => {
                lines.push((line, cells(text, separator)));
                continue;
            }
        };
        skipped.push(Skipped { line, reason });
    }
    let names: Names<'_> = names
        .as_ref()
        .map(|(line, names)| (*line, names.as_slice()));
    if let Some((line, [found])) = names {
        place.line = Some(line);
        let (found, separator) = (found.clone(), separator_words);
        return Err(Problem::OneColumn { found, separator }.at(Box::new(place)));
    }
    let no_rows = |skipped: &[Skipped], why| {
        let (lines, skipped) = (text.lines().count(), skipped.len());
        Problem::NoRows {
            lines,
            skipped,
            why,
        }
        .at(Box::new(place.clone()))
    };
    if lines.is_empty() {
        return Err(no_rows(
            &skipped,
            "is skip_lines too large, or the file cut?",
        ));
    }
    let columns = Columns::new(kind, map, names, &planned)?;

    // What do they say?
    let reader = Reader {
        map,
        columns: &columns,
        decimal: map.decimal()?,
        names,
    };
    let mut clock = Clock::default();
    let is_timed =
        matches!(&columns.time, Some((source, _)) if !matches!(source, Source::Value(_)));
    let mut known = HashSet::new();
    let mut rows = Vec::new();
    let mut faults: Vec<(usize, Fault)> = Vec::new();
    for (line, cells) in lines {
        let is_mark = |mark: &&String| columns.cells().any(|cell| cells.get(cell) == Some(*mark));
        if let Some(mark) = map.skip_rows.iter().find(is_mark) {
            let reason = format!("a cell is \"{mark}\" (skip_rows)");
            skipped.push(Skipped { line, reason });
            continue;
        }
        // What has a time is measured once.
        if is_timed && !known.insert(cells.clone()) {
            let reason = "a copy of a row above".to_owned();
            skipped.push(Skipped { line, reason });
            continue;
        }
        match reader.row(line, &cells, &mut clock) {
            Ok(row) => rows.push(row),
            Err(fault) => faults.push((line, fault)),
        }
    }
    skipped.sort_by_key(|skipped| skipped.line);
    let others = faults.len().saturating_sub(1);
    if let Some((line, mut fault)) = faults.into_iter().next() {
        if let Problem::Cell { more, .. } | Problem::Short { more, .. } = &mut fault.problem {
            *more = others;
        }
        place.line = Some(line);
        place.part = fault.column.map(Part::Column);
        return Err(fault.problem.at(Box::new(place)));
    }
    if rows.is_empty() {
        return Err(no_rows(&skipped, "do comment and skip_rows mark too much?"));
    }
    let visits = stops::visits(rows, map, &columns, &planned).map_err(|(line, problem)| {
        place.line = Some(line);
        problem.at(Box::new(place.clone()))
    })?;
    let stops = visits.last().map_or(0, |(_, visit)| visit.stop + 1);
    let numbered = visits.iter().enumerate();
    Ok(Imported {
        header: header(kind, &columns),
        rows: numbered
            .map(|(index, row)| cells_of(kind, index, row))
            .collect(),
        skipped,
        stops,
        notices: notices(map, &columns),
    })
}

fn header(kind: Kind, columns: &Columns) -> Vec<String> {
    let before: &[&str] = match kind {
        Kind::Lengths => &["time_s", "station", "repeat", "run", "direction"],
        Kind::Points => &["time_s", "repeat", "run", "direction"],
    };
    let before = before.iter().map(|&name| name.to_owned());
    let axes = columns.axes.iter().map(|axis| axis.name.clone());
    let numbers = columns.numbers.iter().map(|number| number.name.clone());
    before
        .chain(axes)
        .chain(["target".to_owned()])
        .chain(numbers)
        .collect()
}

/// The cells of a row of the table, in the order of [`header`].
fn cells_of(kind: Kind, index: usize, (row, visit): &(Row, Visit)) -> Vec<String> {
    let counted = || index.to_string();
    let mut cells = vec![row.time_s.map_or_else(counted, |time_s| time_s.to_string())];
    if kind == Kind::Lengths {
        cells.push(row.station.clone().unwrap_or_default());
    }
    let on_bed = visit.run.is_empty();
    let direction = if on_bed {
        String::new()
    } else {
        visit.direction.to_string()
    };
    cells.extend([visit.repeat.to_string(), visit.run.clone(), direction]);
    cells.extend(visit.positions.iter().map(f64::to_string));
    cells.push(visit.target.clone());
    let numbers = row
        .numbers
        .iter()
        .map(|number| number.map(|n| n.to_string()));
    cells.extend(numbers.map(Option::unwrap_or_default));
    cells
}

/// What was not read.
fn notices(map: &Map, columns: &Columns) -> Vec<String> {
    let by_path = !map.stops.path.is_empty();
    let said = [
        (
            columns.time.is_none(),
            "no column holds the time: the rows are counted, 1 s each; rates of drift will be per row",
        ),
        (
            columns.target.is_none(),
            "no column holds the target: it follows from the order of the rows",
        ),
        (
            by_path,
            "where the machine stood follows from the order of the rows and the path",
        ),
        (
            columns.direction.is_none() && !by_path,
            "no column holds the direction: it is that of the motion from stop to stop",
        ),
        (
            columns.repeat.is_none(),
            "no column holds the repeat: visits to one position from one side are counted",
        ),
    ];
    let said = said.into_iter().filter(|(is_missing, _)| *is_missing);
    said.map(|(_, text)| text.to_owned()).collect()
}
