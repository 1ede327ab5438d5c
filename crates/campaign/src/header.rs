//! The header of a CSV file: which columns a file may have, and all that is wrong with those it has.

use std::fmt;
use std::path::Path;

use crate::logged::is_column;
use crate::{Alternatives, Error, Place, Problem};

/// Characters of a line that are quoted.
const MOST_QUOTED: usize = 80;

/// What is wrong with a column of a header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ColumnFault {
    /// The format does not have it.
    Unknown {
        /// Its name.
        column: String,
        /// The column that could be meant; if that one is missing, it is not reported as another fault.
        nearest: Option<String>,
    },
    /// It stands there a second time.
    Twice {
        /// Its name.
        column: String,
    },
    /// It must be there.
    Missing {
        /// Its name.
        column: String,
    },
}

impl fmt::Display for ColumnFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown {
                column,
                nearest: Some(nearest),
            } => write!(f, "`{column}` is unknown, did you mean `{nearest}`?"),
            Self::Unknown { column, .. } => write!(f, "`{column}` is unknown"),
            Self::Twice { column } => write!(f, "`{column}` stands twice"),
            Self::Missing { column } => write!(f, "`{column}` is missing"),
        }
    }
}

/// Refuses a header in which a column is not one of `required` or `optional` (in which `<name>` stands
/// for any text), stands twice, or is missing: with all that is wrong.
pub(crate) fn check(
    file: &Path,
    line: usize,
    header: &[&str],
    required: &[&str],
    optional: &[&str],
) -> Result<(), Error> {
    if header.iter().any(|column| column.contains('\r')) {
        let separator = "commas, but the lines by CR alone, as on old Macs";
        return Err(Problem::Separator { separator }.at(Place::line(file, line)));
    }
    if let [whole] = header {
        for (separator, words) in [(';', "semicolons"), ('\t', "tabs")] {
            if whole.contains(separator) {
                return Err(Problem::Separator { separator: words }.at(Place::line(file, line)));
            }
        }
    }
    let known: Vec<&str> = required.iter().chain(optional).copied().collect();
    let is_known = |column: &str| known.iter().any(|known| is_column(known, column));
    if !header.iter().any(|column| is_known(column)) {
        return Err(Problem::NoHeader {
            found: beginning(&header.join(",")),
            expected: required.join(","),
        }
        .at(Place::line(file, line)));
    }
    let faults = faults(header, required, &known);
    match faults.as_slice() {
        [] => Ok(()),
        [fault] => {
            let (column, problem) = single(fault, header, &known);
            Err(problem.at(Place::column(file, line, column)))
        }
        _ => Err(Problem::Columns {
            faults,
            known: known.iter().map(|&column| column.to_owned()).collect(),
        }
        .at(Place::line(file, line))),
    }
}

/// The beginning of a line that may have any length.
fn beginning(line: &str) -> String {
    match line.char_indices().nth(MOST_QUOTED) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line.to_owned(),
    }
}

/// All faults: those of the columns that are there in their order, then those that are not.
fn faults(header: &[&str], required: &[&str], known: &[&str]) -> Vec<ColumnFault> {
    let mut missing: Vec<&str> = required.to_vec();
    missing.retain(|column| !header.contains(column));
    let mut faults = Vec::new();
    for (i, &column) in header.iter().enumerate() {
        if header[..i].contains(&column) {
            let column = column.to_owned();
            faults.push(ColumnFault::Twice { column });
        } else if !known.iter().any(|known| is_column(known, column)) {
            // What is missing is meant rather than what is there already.
            let nearest = Alternatives::new(column, &missing).nearest;
            let nearest = nearest.or_else(|| alternatives(column, known).nearest);
            missing.retain(|&column| nearest.as_deref() != Some(column));
            let column = column.to_owned();
            faults.push(ColumnFault::Unknown { column, nearest });
        }
    }
    faults.extend(missing.into_iter().map(|column| ColumnFault::Missing {
        column: column.to_owned(),
    }));
    faults
}

/// The columns that exist. One that begins like a column with a name of its own is meant as such, however far the edits are.
fn alternatives(column: &str, known: &[&str]) -> Alternatives {
    let begins_like = |known: &&&str| {
        let begin = known.split_once("<name>");
        begin.is_some_and(|(begin, _)| column.starts_with(begin))
    };
    let mut alternatives = Alternatives::new(column, known);
    if let Some(meant) = known.iter().find(begins_like) {
        alternatives.nearest = Some((*meant).to_owned());
    }
    alternatives
}

/// A fault that is the only one: its column and what is wrong there.
fn single<'f>(fault: &'f ColumnFault, header: &[&str], known: &[&str]) -> (&'f str, Problem) {
    match fault {
        ColumnFault::Unknown { column, nearest } => {
            let alternatives = Alternatives {
                nearest: nearest.clone(),
                ..alternatives(column, known)
            };
            (column, Problem::UnknownColumn { alternatives })
        }
        ColumnFault::Twice { column } => (column, Problem::DuplicateColumn),
        ColumnFault::Missing { column } => (column, missing(header)),
    }
}

pub(crate) fn missing(header: &[&str]) -> Problem {
    Problem::MissingColumn {
        found: header.iter().map(|&column| column.to_owned()).collect(),
    }
}
