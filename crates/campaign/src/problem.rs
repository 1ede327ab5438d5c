//! What can be wrong with the files of a campaign.

use std::io;

use trueaxis_files::{DocumentProblem, FileProblem, Located, OfDocument, counted};

use crate::{Alternatives, ColumnFault, Place, UnitMistake};

/// A campaign that cannot be read or written.
///
/// Its message says where, what was found, what is expected and how to correct it.
pub type Error = Located<Problem>;

impl OfDocument for Problem {
    fn of_document(problem: DocumentProblem) -> Self {
        Self::Document(problem)
    }
}

impl Problem {
    pub(crate) fn value(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Document(DocumentProblem::value(found, expected))
    }

    pub(crate) fn missing(name: &str) -> Self {
        Self::Document(DocumentProblem::missing(name))
    }

    /// The error with this problem.
    pub(crate) fn at(self, place: Box<Place>) -> Error {
        let problem = self;
        Error { place, problem }
    }
}

/// What can be wrong with the files of a campaign. An [`Error`] says where it is.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Problem {
    /// Of a JSON document, or of a name or value anywhere.
    #[error(transparent)]
    Document(DocumentProblem),

    // The file as a whole.
    /// The file cannot be read.
    #[error(transparent)]
    File(FileProblem),
    /// The file cannot be written.
    #[error("the file cannot be written; check the folder and its permissions")]
    Unwritable { source: io::Error },
    /// The file holds nothing.
    #[error("the file is empty; was it saved completely?")]
    Empty,
    /// The file is not UTF-8.
    #[error("this line is not UTF-8 text; save the file with the encoding UTF-8")]
    NotUtf8,
    /// The file holds NUL bytes.
    #[error(
        "the file holds NUL bytes, so it is no text; is it the right file? Save it as text with the encoding UTF-8"
    )]
    NulBytes,

    /// The kinematics cannot be built.
    #[error("{problem}")]
    Machine {
        problem: Box<trueaxis_kinematics::Error>,
    },

    // What belongs together.
    /// The campaign has no measurement.
    #[error(
        "the campaign has no data; name its file in `lengths` or `points`, or add a `verification`"
    )]
    NothingMeasured,
    /// Lengths and points in one campaign.
    #[error(
        "the campaign has both `lengths` and `points`; choose one: keep `lengths` for multilateration, or `points` if another \
         instrument measured coordinates"
    )]
    TwoMeasurements,
    /// The data refer to a list that is empty.
    #[error(
        "the list is empty, but `{needed_by}` refers to it; add one entry for each name in the data"
    )]
    EmptyList {
        /// `lengths` or `points`.
        needed_by: &'static str,
    },

    // CSV files.
    /// The fields are not separated by commas.
    #[error(
        "the columns are separated by {separator}; expected commas, line ends of LF or CR LF, and points as \
         decimal marks: export the table as comma separated values"
    )]
    Separator { separator: &'static str },
    /// The first line names no column.
    #[error("no column is known in `{found}`; expected the header {expected}")]
    NoHeader { found: String, expected: String },
    /// A column that must be there.
    #[error("the column is missing; found only {}: add it", found.join(", "))]
    MissingColumn { found: Vec<String> },
    /// A column that the format does not have.
    #[error("unknown column; {alternatives}")]
    UnknownColumn { alternatives: Alternatives },
    /// A column stands twice in the header.
    #[error("the column stands twice in the header; remove one")]
    DuplicateColumn,
    /// More than one column of the header is wrong.
    #[error(
        "{} columns are wrong: {}; known: {}",
        faults.len(),
        in_a_row(faults),
        known.join(", ")
    )]
    Columns {
        faults: Vec<ColumnFault>,
        known: Vec<String>,
    },
    /// A row is longer or shorter than the header.
    #[error(
        "found {found} fields, expected {expected} as in the header; a decimal comma would split a number in two"
    )]
    FieldCount { found: usize, expected: usize },
    /// A header without rows.
    #[error("there are no rows below the header; expected one at least")]
    NoRows,

    // What the rows say together.
    /// A commanded position beyond the end of the axis.
    #[error(
        "position {position} {unit} is outside the travel {low} to {high} {unit} of the axis; {hint}"
    )]
    OutsideTravel {
        position: f64,
        /// Lower end, as in `campaign.json`.
        low: f64,
        /// Upper end, as in `campaign.json`.
        high: f64,
        /// mm or deg.
        unit: &'static str,
        hint: &'static str,
    },
    /// A target read twice without a motion in between.
    #[error(
        "target `{target}` is read a second time in the same stop, first in line {first_line}; keep one of the two rows, or \
         increase `repeat`"
    )]
    TargetReadTwice { target: String, first_line: usize },
    /// Rows that stand in the file twice.
    #[error(
        "the same stop with the same time {time_s} s stands in line {first_line} already; remove the duplicated rows"
    )]
    StopRepeated { time_s: f64, first_line: usize },
    /// Rows that are not in measuring order.
    #[error(
        "the rows are not in measuring order: the time goes back {}, here from {before_s} s to \
         {time_s} s, and the rows would be {} in {} of stations in the order of time, not {} in {}; sort the table by time_s",
        how_often(*times), counted(*stops_by_time, "stop"), counted(*occupations_by_time, "occupation"),
        counted(*stops, "stop"), counted(*occupations, "occupation")
    )]
    NotInMeasuringOrder {
        times: usize,
        before_s: f64,
        time_s: f64,
        stops: usize,
        occupations: usize,
        stops_by_time: usize,
        occupations_by_time: usize,
    },
    /// The readings of one station under the name of another.
    #[error(
        "all {count} readings of run `{run}` from station `{station}` equal those from station `{original}` \
         (line {original_line}) to the last digit; no two stations see the same lengths: put in what was \
         measured from `{station}`, or remove these rows"
    )]
    StationCopied {
        count: usize,
        run: String,
        station: String,
        original: String,
        original_line: usize,
    },
    /// Positions of one run that are nearly the same.
    #[error(
        "run `{run}` stops at {position} {unit} here and at {other} {unit} in line {other_line}: positions differ in \
         the last digits, and each would be a step of its own; give the commanded positions, not what the encoders \
         show (steps that are meant to differ: by {near} {unit} or more, in a run of their own, or, from 0.001 {unit} \
         on, stopped at one after the other)"
    )]
    NearPositions {
        run: String,
        position: f64,
        other: f64,
        other_line: usize,
        /// mm or deg.
        unit: &'static str,
        /// Below which distance steps are not meant to differ.
        near: f64,
    },
    /// A run, or a line of a verification, in which only other axes move.
    #[error(
        "{kind} `{name}` is of axis {axis}, but {axis} never moves in it, only {}; correct the axis of the {kind} \
         (`ball_carried_by` of a ball bar), its rows or the columns",
        moving.join(", ")
    )]
    WrongAxisMoves {
        /// `run` or `verification`.
        kind: &'static str,
        name: String,
        axis: String,
        moving: Vec<String>,
    },

    // What cannot be true of a machine.
    /// Lengths change more than the targets move.
    #[error(
        "station `{station}` sees the length to target `{target}` change by {change_mm:.3} mm from line {first_line} to \
         here, but the target moves only {moved_mm:.3} mm; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    LengthsTooLarge {
        first_line: usize,
        station: String,
        target: String,
        change_mm: f64,
        moved_mm: f64,
        mistake: Option<Box<UnitMistake>>,
    },
    /// Lengths change less than they must from wherever the station stands.
    #[error(
        "the lengths from station `{station}` to target `{target}` vary by only {spread_mm:.4} mm (standard deviation), \
         expected at least {least_mm:.1} mm for the motion of the target; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    LengthsTooSmall {
        station: String,
        target: String,
        /// Standard deviation of the lengths, mm.
        spread_mm: f64,
        least_mm: f64,
        mistake: Option<Box<UnitMistake>>,
    },
    /// Measured points are not as far apart as the machine moved.
    #[error(
        "the point is {measured_mm:.3} mm from the one in line {first_line}, but nominally {nominal_mm:.3} mm; {}",
        UnitMistake::advice(mistake.as_deref())
    )]
    PointsImpossible {
        first_line: usize,
        measured_mm: f64,
        nominal_mm: f64,
        mistake: Option<Box<UnitMistake>>,
    },
    /// Lengths fit the rough positions of the stations only in another unit.
    #[error(
        "from the approx_mm of station `{station}` the lengths would be {misfit_mm:.1} mm different (80 % of them less); {mistake}"
    )]
    ScaleAgainstApprox {
        station: String,
        misfit_mm: f64,
        mistake: Box<UnitMistake>,
    },
    /// The lengths of a station fit the place of another.
    #[error(
        "the lengths of station `{station}` fit the approx_mm of station `{fits}` (80 \
         % within {fits_misfit_mm:.1} mm) and not its own (80 % within {own_misfit_mm:.1} mm); \
         exchange the names in this column, or the approx_mm in campaign.json"
    )]
    SwappedStations {
        station: String,
        fits: String,
        own_misfit_mm: f64,
        fits_misfit_mm: f64,
    },

    // Writing.
    /// A campaign, made by a program, that contradicts itself.
    #[error("the campaign cannot be written: {problem}")]
    Inconsistent { problem: String },
}

fn in_a_row(faults: &[ColumnFault]) -> String {
    let faults: Vec<String> = faults.iter().map(ToString::to_string).collect();
    faults.join("; ")
}

fn how_often(times: usize) -> String {
    match times {
        1 => "once".to_owned(),
        _ => format!("{times} times"),
    }
}
