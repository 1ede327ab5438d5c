//! What the columns of an export mean.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use trueaxis_files::{DocumentProblem, Place};

use crate::unit::{Quantity, Unit};
use crate::{Error, Problem};

/// What the columns of an export mean: a TOML file, whose fields these are (`docs/import.md`).
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Map {
    /// Between the cells of a row: one sign, `tab`, or `blanks` for any number of blanks and tabs;
    /// `,` if it is not given.
    pub separator: Option<String>,
    /// Decimal sign, `.` if it is not given.
    pub decimal: Option<String>,
    /// Lines before the one with the names of the columns, or before the rows.
    pub skip_lines: usize,
    /// Whether a line names the columns, true if it is not given; else they have numbers from 1.
    pub column_names: Option<bool>,
    /// Lines that begin with one of these are skipped.
    pub comment: Vec<String>,
    /// Rows are skipped if one of the cells that the map reads is one of these.
    pub skip_rows: Vec<String>,
    /// Columns of the table by name, but those of the axes.
    pub columns: BTreeMap<String, ColumnMap>,
    /// Axes of the machine by name; the unit is that of positions in the path, too.
    pub axes: BTreeMap<String, ColumnMap>,
    /// Columns that hold several things in one text.
    pub split: Vec<Split>,
    /// Names of targets, stations and runs in the export, and what the campaign calls them.
    pub rename: BTreeMap<String, String>,
    /// Rows that belong together.
    pub stops: Stops,

    #[serde(skip)]
    file: Option<PathBuf>,
    #[serde(skip)]
    text: String,
}

/// Where a column of the table, or the position of an axis, comes from.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(
    deny_unknown_fields,
    default,
    expecting = "as { column = \"X\", unit = \"mm\" }"
)]
pub struct ColumnMap {
    /// The column of the export; not if a pattern or the path tells it.
    pub column: Option<ColumnName>,
    /// Instead of a column, the same in all rows.
    pub value: Option<ColumnName>,
    /// Unit of a coordinate, a length, a time or a position.
    pub unit: Option<String>,
}

/// A column by its name or number, or a value.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected a text or a number")]
pub enum ColumnName {
    /// A number, of a column from 1.
    Number(usize),
    /// A text.
    Name(String),
    /// A value with a point.
    Value(f64),
}

/// A column that holds several things in one text.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// The column of the export.
    pub column: ColumnName,
    /// What the text is made of, as `{target}_{X}`: names of columns of the table and axes; `{}` is ignored.
    pub pattern: String,
}

/// Rows that belong together: those of one visit of the machine.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Stops {
    /// Names of the targets in the order in which they are read at a stop. Without a column for the target, each stop
    /// has that many rows.
    pub targets: Vec<String>,
    /// The path of the machine, where no column tells its positions; it begins anew at each station and when it is
    /// complete.
    pub path: Vec<Leg>,
}

/// A part of the path, in which one axis moves.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leg {
    /// The run, as in `campaign.json`.
    pub run: String,
    /// The axis that moves.
    pub axis: String,
    /// Its positions, stop by stop, or else `from`, `to` and `step`.
    pub positions: Option<Vec<f64>>,
    /// The first position.
    pub from: Option<f64>,
    /// The last position.
    pub to: Option<f64>,
    /// From one position to the next.
    pub step: Option<f64>,
    /// Whether the axis then visits them in reverse order, the last one again first.
    #[serde(default)]
    pub back: bool,
    /// The targets read at its stops, if these are others than those of all stops.
    #[serde(default)]
    pub targets: Vec<String>,
    /// Where other axes stand; at 0 if nothing is said.
    #[serde(default)]
    pub at: BTreeMap<String, f64>,
}

/// Beginnings of what serde says about a value, in contrast to what the parser says about the syntax.
const OF_A_VALUE: [&str; 5] = [
    "unknown",
    "missing field",
    "invalid type",
    "invalid value",
    "expected a",
];

impl Map {
    /// Reads a map.
    ///
    /// # Errors
    /// If the file cannot be read or [`Self::parse`] refuses it.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let hint = "--map wants a TOML file that says what the columns mean (docs/import.md)";
        let bytes = crate::import::bytes(file, hint)?;
        let text =
            crate::decode::decode(&bytes).map_err(|problem| problem.at(Place::file(file)))?;
        Self::parse(&text, Some(file))
    }

    /// Reads a map from its text; `file` is only named.
    ///
    /// # Errors
    /// With the line.
    pub fn parse(text: &str, file: Option<&Path>) -> Result<Self, Error> {
        let mut map: Self = toml::from_str(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            let line = 1 + text.bytes().take(start).filter(|&b| b == b'\n').count();
            let message = error.message();
            let problem = match OF_A_VALUE.iter().any(|start| message.starts_with(start)) {
                true => Problem::Document(DocumentProblem::from_serde(message)),
                false => Problem::Toml {
                    problem: message.replace('\n', ", "),
                },
            };
            problem.at(Box::new(Place {
                file: file.map(Path::to_owned),
                line: Some(line),
                part: None,
            }))
        })?;
        map.file = file.map(Path::to_owned);
        map.text = text.to_owned();
        Ok(map)
    }

    /// The separator as a character and by name.
    pub(crate) fn separator(&self) -> Result<(char, &'static str), Error> {
        let name = self.separator.as_deref().unwrap_or(",");
        let mut signs = name.chars();
        let found = match (name, signs.next(), signs.next()) {
            ("tab" | "\t", ..) => ('\t', "a tab"),
            ("blanks" | " ", ..) => (' ', "any number of blanks"),
            (";", ..) => (';', "a semicolon"),
            (",", ..) => (',', "a comma"),
            (_, Some(sign), None) if sign.is_ascii_punctuation() && !"\"+-.".contains(sign) => {
                (sign, "right")
            }
            _ => {
                let expected = "one sign as \";\", or \"tab\", or \"blanks\"";
                return Err(self.wrong("separator", format!("found \"{name}\""), expected));
            }
        };
        if found.0 == self.decimal()? {
            let expected = "two signs: separator = \";\" where decimals have commas";
            let found = "a comma is both separator and decimal sign";
            return Err(self.wrong("decimal", found, expected));
        }
        Ok(found)
    }

    /// The decimal sign.
    pub(crate) fn decimal(&self) -> Result<char, Error> {
        match self.decimal.as_deref() {
            None | Some(".") => Ok('.'),
            Some(",") => Ok(','),
            Some(other) => {
                Err(self.wrong("decimal", format!("found \"{other}\""), "\".\" or \",\""))
            }
        }
    }

    /// The unit that a column or an axis has.
    pub(crate) fn unit(
        &self,
        field: &str,
        name: Option<&str>,
        of: &[Quantity],
    ) -> Result<Unit, Error> {
        let Some(name) = name else {
            let example = Unit::named("", of)
                .err()
                .map(|units| units.known.join(", "));
            return Err(self.wrong(
                field,
                "the unit is not stated",
                &format!("unit = \"…\", one of {}", example.unwrap_or_default()),
            ));
        };
        Unit::named(name, of).map_err(|alternatives| {
            let problem = DocumentProblem::UnknownName {
                what: "unit",
                name: name.to_owned(),
                alternatives,
            };
            self.refused(field, problem)
        })
    }

    pub(crate) fn unit_of_column(&self, name: &str, of: &[Quantity]) -> Result<Unit, Error> {
        let column = self.columns.get(name);
        let unit = column.and_then(|column| column.unit.as_deref());
        self.unit(&format!("columns.{name}"), unit, of)
    }

    /// An error with a value of the map.
    pub(crate) fn wrong(&self, field: &str, found: impl Into<String>, expected: &str) -> Error {
        self.refused(field, DocumentProblem::value(found, expected))
    }

    /// An error with a name or value of the map.
    pub(crate) fn refused(&self, field: &str, problem: DocumentProblem) -> Error {
        Problem::Document(problem).at(self.place(field))
    }

    /// The error that nothing says the `name` of a row.
    pub(crate) fn nothing(&self, name: &str, example: &str) -> Error {
        let (name, example) = (name.to_owned(), example.to_owned());
        Problem::Nothing { name, example }.at(self.whole())
    }

    pub(crate) fn place(&self, field: &str) -> Box<Place> {
        let key = field.rsplit('.').next().unwrap_or(field);
        let key = key.split('[').next().unwrap_or(key);
        let is_key = |line: &str| {
            let behind = line
                .trim_start()
                .trim_start_matches(['"', '['])
                .strip_prefix(key);
            behind.is_some_and(|behind| behind.starts_with([' ', '=', '"', ']', '.']))
        };
        let line = (1..).zip(self.text.lines()).find(|(_, line)| is_key(line));
        Box::new(Place {
            file: self.file.clone(),
            line: line.map(|(number, _)| number),
            ..*Place::in_field(field)
        })
    }

    pub(crate) fn whole(&self) -> Box<Place> {
        Box::new(Place {
            file: self.file.clone(),
            ..Place::default()
        })
    }
}

impl ColumnName {
    /// The text of a value.
    pub(crate) fn text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Value(number) => number.to_string(),
            Self::Name(name) => name.clone(),
        }
    }
}
