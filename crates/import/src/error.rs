//! What can be wrong with an export or its map.

use trueaxis_files::{
    Alternatives, DocumentProblem, FileProblem, Located, OfDocument, Place, counted,
};

/// An export that cannot be imported, or a map that cannot be read.
///
/// Its message says where, what was found, what is expected and how to correct it.
pub type Error = Located<Problem>;

impl OfDocument for Problem {
    fn of_document(problem: DocumentProblem) -> Self {
        Self::Document(problem)
    }
}

impl Problem {
    pub(crate) fn at(self, place: Box<Place>) -> Error {
        let problem = self;
        Error { place, problem }
    }
}

/// What can be wrong with an export or its map. An [`Error`] says where.
#[derive(Debug, thiserror::Error)]
#[expect(missing_docs, reason = "the message shows what each field is")]
pub enum Problem {
    /// Of a name or value anywhere.
    #[error(transparent)]
    Document(DocumentProblem),
    /// The file cannot be read.
    #[error(transparent)]
    File(FileProblem),
    /// The file holds a NUL, as programs and spreadsheets in their own format do.
    #[error("this is not text; export the points as ASCII or CSV")]
    NoText,
    /// The map is not TOML.
    #[error("not valid TOML: {problem}; texts stand in quotes, as in separator = \";\"")]
    Toml { problem: String },
    /// The map names a column that the export does not have.
    #[error("the export has no column `{name}` in its line {line} of names; {alternatives}")]
    NoSuchColumn {
        name: String,
        line: usize,
        alternatives: Alternatives,
    },
    /// The map names columns, but the export has no line with names.
    #[error(
        "the map names the column `{name}`, but with column_names = false columns have only numbers, such as column = 3"
    )]
    NoNames { name: String },
    /// The line with the names of the columns is one cell.
    #[error(
        "the line has only one column, `{found}`; is the separator {separator}, and is this the line that names the columns \
         (skip_lines)?"
    )]
    OneColumn {
        found: String,
        separator: &'static str,
    },
    /// Nothing says what a column of the table shall hold.
    #[error("nothing says the {name} of a row; add {example}")]
    Nothing { name: String, example: String },
    /// A row has fewer cells than the map needs.
    #[error(
        "found {found} cells, but the map needs {needed}; if this is not a reading, put a mark of such lines into `comment` or `skip_rows`{}",
        and_more(*more)
    )]
    Short {
        found: usize,
        needed: usize,
        more: usize,
    },
    /// A cell that is not understood.
    #[error("found \"{found}\"; expected {expected}{}", and_more(*more))]
    Cell {
        found: String,
        expected: String,
        more: usize,
    },
    /// No row is left.
    #[error("no rows are left: {lines} lines were read, {skipped} skipped; {why}")]
    NoRows {
        lines: usize,
        skipped: usize,
        why: &'static str,
    },
    /// A stop without all of its rows.
    #[error(
        "the stop that begins here has {}, expected {expected} ({}), because the rows have no column for the target; \
         insert the missing row, or map a column with the name of the point",
        counted(*found, "row"), targets.join(", ")
    )]
    PartOfStop {
        found: usize,
        expected: usize,
        targets: Vec<String>,
    },
    /// A target that the stop of the path does not have.
    #[error(
        "target `{target}` is read where the path has {stop} with {}; a stop above is missing or one \
         too many: compare the path in the map with the readings", targets.join(", ")
    )]
    NotPlanned {
        target: String,
        stop: String,
        targets: Vec<String>,
    },
    /// Rows that are not in measuring order.
    #[error(
        "the rows are not in measuring order: the time goes back here, and in the order of time they would be {stops_by_time} \
         stops, not {stops}; sort the export by time"
    )]
    NotInMeasuringOrder { stops: usize, stops_by_time: usize },
    /// The stops are no whole number of rounds of the path.
    #[error(
        "the export has {}{}, a round of the path has {path}; {} too many or {} too few: compare the path in the \
         map with the readings",
        counted(*stops, "stop"), of(station), stops % path, path - stops % path
    )]
    PartOfPath {
        stops: usize,
        station: Option<String>,
        path: usize,
    },
}

fn and_more(more: usize) -> String {
    match more {
        0 => String::new(),
        _ => format!(" (and {})", counted(more, "more row")),
    }
}

fn of(station: &Option<String>) -> String {
    let words = station.as_ref().map(|name| format!(" of station {name}"));
    words.unwrap_or_default()
}
