//! What can be wrong with the files of a campaign.

use std::io;
use std::path::PathBuf;

use crate::{Alternatives, Place, UnitMistake};

/// A campaign that cannot be read or written.
///
/// Every message says where, what was found, what is expected and how to mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    // The file as a whole.
    /// There is no such file.
    #[error("{place}: there is no such file; {mend}")]
    NotFound {
        /// The file.
        place: Box<Place>,
        /// Who names the file, or what to give instead.
        mend: String,
    },
    /// A folder stands where a file is needed.
    #[error("{place}: this is a folder, expected a file; {mend}")]
    Folder {
        /// The folder.
        place: Box<Place>,
        /// Who names the file, or what to give instead.
        mend: String,
    },
    /// The operating system refuses to read the file.
    #[error("{place}: the file cannot be read; check its permissions")]
    Unreadable {
        /// The file.
        place: Box<Place>,
        /// The reason of the operating system.
        source: io::Error,
    },
    /// The file cannot be written.
    #[error("{place}: the file cannot be written; check the folder and its permissions")]
    Unwritable {
        /// The file or folder.
        place: Box<Place>,
        /// The reason of the operating system.
        source: io::Error,
    },
    /// The file holds nothing.
    #[error("{place}: the file is empty; was it saved completely?")]
    Empty {
        /// The file.
        place: Box<Place>,
    },
    /// The file is not UTF-8.
    #[error("{place}: this line is not UTF-8 text; save the file with the encoding UTF-8")]
    NotUtf8 {
        /// The first such line.
        place: Box<Place>,
    },

    // campaign.json as a document.
    /// The text is not JSON.
    #[error(
        "{place}, character {character}: not valid JSON: {problem}; expected JSON as in RFC \
         8259 (no comments, no trailing commas)"
    )]
    Syntax {
        /// The line where the parser stopped.
        place: Box<Place>,
        /// The character of that line, from 1; 0 after the last line.
        character: usize,
        /// The parser's reason.
        problem: String,
    },
    /// Another document of this project.
    #[error(
        "{place}: this is a trueaxis {kind}, not a campaign; give the path of the campaign.json \
         instead"
    )]
    OtherDocument {
        /// The field `format`.
        place: Box<Place>,
        /// Which one, as `calibration`.
        kind: String,
    },
    /// Some other JSON.
    #[error("{place}: found {found}; expected \"trueaxis-campaign\": is this the right file?")]
    Format {
        /// The field `format`.
        place: Box<Place>,
        /// Its value as JSON.
        found: String,
    },
    /// A version of the format that this release does not know.
    #[error(
        "{place}: found {found}; expected 1: a higher version needs a newer release of trueaxis"
    )]
    Version {
        /// The field `version`.
        place: Box<Place>,
        /// Its value as JSON.
        found: String,
    },
    /// A field that the format does not have.
    #[error("{place}: unknown field `{name}`; {alternatives}")]
    UnknownField {
        /// The field.
        place: Box<Place>,
        /// Its name.
        name: String,
        /// The fields that exist there.
        alternatives: Alternatives,
    },
    /// A field that must be there.
    #[error("{place}: field `{name}` is missing; add it")]
    MissingField {
        /// The object that lacks it.
        place: Box<Place>,
        /// Its name.
        name: String,
    },

    // Names and values, in JSON and CSV.
    /// A value that cannot be.
    #[error("{place}: {found}; expected {expected}")]
    Value {
        /// The field or cell.
        place: Box<Place>,
        /// The value and what is wrong with it.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A name that nothing has.
    #[error("{place}: unknown {what} `{name}`; {alternatives}")]
    UnknownName {
        /// The field or cell.
        place: Box<Place>,
        /// What it should name, as `axis`.
        what: &'static str,
        /// The name found.
        name: String,
        /// The names that exist.
        alternatives: Alternatives,
    },
    /// Two things of one kind share a name.
    #[error("{place}: {what} `{name}` has this name already in {first}; give each its own")]
    DuplicateName {
        /// The second use.
        place: Box<Place>,
        /// What they are, as `target`.
        what: &'static str,
        /// The name.
        name: String,
        /// Field path of the first use.
        first: String,
    },
    /// The kinematics cannot be built.
    #[error("{place}: {problem}")]
    Machine {
        /// The axis or the branches.
        place: Box<Place>,
        /// Why.
        problem: Box<trueaxis_kinematics::Error>,
    },

    // What belongs together.
    /// The campaign has no measurement.
    #[error(
        "{place}: the campaign has no data; name its file in `lengths` or `points`, or add a \
         `verification`"
    )]
    NothingMeasured {
        /// The file.
        place: Box<Place>,
    },
    /// Lengths and points in one campaign.
    #[error(
        "{place}: the campaign has both `lengths` and `points`; choose one: keep `lengths` for \
         multilateration, or `points` if another instrument measured coordinates"
    )]
    TwoMeasurements {
        /// The field `points`.
        place: Box<Place>,
    },
    /// The data refer to a list that is empty.
    #[error(
        "{place}: the list is empty, but `{needed_by}` refers to it; add one entry for each \
         name in the data"
    )]
    EmptyList {
        /// The list, as `stations`.
        place: Box<Place>,
        /// `lengths` or `points`.
        needed_by: &'static str,
    },

    // CSV files.
    /// The fields are not separated by commas.
    #[error(
        "{place}: the columns are separated by {separator}; expected commas, and points as \
         decimal marks: export the table as comma separated values"
    )]
    Separator {
        /// The header.
        place: Box<Place>,
        /// The separator found, in words.
        separator: &'static str,
    },
    /// The first line names no column.
    #[error("{place}: no column is known in `{found}`; expected the header {expected}")]
    NoHeader {
        /// The first line.
        place: Box<Place>,
        /// Its text.
        found: String,
        /// The header wanted.
        expected: String,
    },
    /// A column that must be there.
    #[error("{place}: the column is missing; found only {}: add it", found.join(", "))]
    MissingColumn {
        /// The header; the part is the missing column.
        place: Box<Place>,
        /// The columns that are there.
        found: Vec<String>,
    },
    /// A column that the format does not have.
    #[error("{place}: unknown column; {alternatives}")]
    UnknownColumn {
        /// The header; the part is the unknown column.
        place: Box<Place>,
        /// The columns that exist.
        alternatives: Alternatives,
    },
    /// A column stands twice in the header.
    #[error("{place}: the column stands twice in the header; remove one")]
    DuplicateColumn {
        /// The header; the part is the column.
        place: Box<Place>,
    },
    /// A row is longer or shorter than the header.
    #[error(
        "{place}: found {found} fields, expected {expected} as in the header; a decimal comma \
         would split a number in two"
    )]
    FieldCount {
        /// The row.
        place: Box<Place>,
        /// Number of fields in the row.
        found: usize,
        /// Number of columns.
        expected: usize,
    },
    /// A header without rows.
    #[error("{place}: there are no rows below the header; expected one for each reading")]
    NoRows {
        /// The file.
        place: Box<Place>,
    },

    // What the rows say together.
    /// A commanded position beyond the end of the axis.
    #[error(
        "{place}: position {position} {unit} is outside the travel {low} to {high} {unit} of \
         the axis; {mend}"
    )]
    OutsideTravel {
        /// The cell.
        place: Box<Place>,
        /// The position as in the file.
        position: f64,
        /// Lower end, as in `campaign.json`.
        low: f64,
        /// Upper end, as in `campaign.json`.
        high: f64,
        /// mm or deg.
        unit: &'static str,
        /// What could be done.
        mend: &'static str,
    },
    /// A target read twice without a motion in between.
    #[error(
        "{place}: target `{target}` is read a second time in the same stop, first in line \
         {first_line}; keep one of the two rows, or count up `repeat`"
    )]
    TargetReadTwice {
        /// The second row.
        place: Box<Place>,
        /// The target.
        target: String,
        /// The first row.
        first_line: usize,
    },
    /// Rows that stand in the file twice.
    #[error(
        "{place}: the same visit with the same time {time_s} s stands in line {first_line} \
         already; remove the duplicated rows"
    )]
    VisitRepeated {
        /// The second row.
        place: Box<Place>,
        /// Its time, s.
        time_s: f64,
        /// The first row.
        first_line: usize,
    },
    /// A run in which only other axes move.
    #[error(
        "{place}: run `{run}` is of axis {axis}, but {axis} never moves in it, only {}; mend the \
         axis of the run or the columns",
        moving.join(", ")
    )]
    WrongAxisMoves {
        /// The first row where another axis has moved.
        place: Box<Place>,
        /// The run.
        run: String,
        /// Its axis.
        axis: String,
        /// The axes that do move.
        moving: Vec<String>,
    },

    // What cannot be true of a machine.
    /// Lengths change more than the targets move.
    #[error(
        "{place}: station `{station}` sees the length to target `{target}` change by \
         {change_mm:.3} mm from line {first_line} to here, but the target moves only \
         {moved_mm:.3} mm; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    LengthsTooLarge {
        /// The later of two rows.
        place: Box<Place>,
        /// The earlier of the two rows.
        first_line: usize,
        /// The station.
        station: String,
        /// The target.
        target: String,
        /// Change of the length, mm.
        change_mm: f64,
        /// Nominal distance between the target's two positions, mm.
        moved_mm: f64,
        /// What would explain it.
        mistake: Option<Box<UnitMistake>>,
    },
    /// Lengths change less than they must from wherever the station stands.
    #[error(
        "{place}: the lengths from station `{station}` to target `{target}` vary by only \
         {spread_mm:.4} mm (standard deviation), expected at least {least_mm:.1} mm for the \
         motion of the target; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    LengthsTooSmall {
        /// The first row of the station.
        place: Box<Place>,
        /// The station.
        station: String,
        /// The target.
        target: String,
        /// Standard deviation of the lengths, mm.
        spread_mm: f64,
        /// The least that the motion allows, mm.
        least_mm: f64,
        /// What would explain it.
        mistake: Option<Box<UnitMistake>>,
    },
    /// Measured points are not as far apart as the machine moved.
    #[error(
        "{place}: the point is {measured_mm:.3} mm from the one in line {first_line}, but \
         nominally {nominal_mm:.3} mm; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    PointsImpossible {
        /// The later of two rows.
        place: Box<Place>,
        /// The earlier of the two rows.
        first_line: usize,
        /// Distance of the measured points, mm.
        measured_mm: f64,
        /// Nominal distance, mm.
        nominal_mm: f64,
        /// What would explain it.
        mistake: Option<Box<UnitMistake>>,
    },
    /// Lengths fit the rough positions of the stations only in another unit.
    #[error(
        "{place}: from the approx_mm of station `{station}` the lengths would be {misfit_mm:.1} \
         mm different (80 % of them less); {mistake}"
    )]
    ScaleAgainstApprox {
        /// The first row of the station.
        place: Box<Place>,
        /// The station.
        station: String,
        /// Misfit as given, mm.
        misfit_mm: f64,
        /// What would explain it.
        mistake: Box<UnitMistake>,
    },
    /// The lengths of a station fit the place of another.
    #[error(
        "{place}: the lengths of station `{station}` fit the approx_mm of station `{fits}` (80 \
         % within {fits_misfit_mm:.1} mm) and not its own (80 % within {own_misfit_mm:.1} mm); \
         exchange the names in this column, or the approx_mm in campaign.json"
    )]
    SwappedStations {
        /// The first row of the station.
        place: Box<Place>,
        /// The station named in the rows.
        station: String,
        /// The station that it seems to be.
        fits: String,
        /// Misfit to its own place, mm.
        own_misfit_mm: f64,
        /// Misfit to the other place, mm.
        fits_misfit_mm: f64,
    },

    // Writing.
    /// A campaign, made by a program, that contradicts itself.
    #[error("{}: the campaign cannot be written: {problem}", folder.display())]
    Inconsistent {
        /// The folder to write to.
        folder: PathBuf,
        /// What is wrong.
        problem: String,
    },
}
