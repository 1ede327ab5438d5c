//! Finding the columns of a map among those of an export.

use trueaxis_files::{Alternatives, DocumentProblem};

use crate::columns::{
    AxisColumn, COMMON, COORDINATES, LENGTH, Names, NumberColumn, SIGMA, Source, is_logged,
};
use crate::import::Kind;
use crate::map::{ColumnMap, ColumnName, Map};
use crate::path::PlannedStop;
use crate::pattern::Pattern;
use crate::unit::{Quantity, Unit};
use crate::{Error, Problem};

/// µm in a mm.
const MICROMETRES: f64 = 1e3;

/// A cell, from 0, with several things, and what it is made of.
pub(crate) type SplitCell = (usize, Pattern);

/// All columns of the map's `split`.
pub(crate) fn splits(map: &Map, names: Names<'_>) -> Result<Vec<SplitCell>, Error> {
    let mut splits = Vec::new();
    for (index, split) in map.split.iter().enumerate() {
        let field = format!("split[{index}].pattern");
        let pattern = Pattern::parse(&split.pattern).map_err(|found| {
            map.wrong(
                &field,
                found,
                "as {target}_{X}: names of columns and axes in braces",
            )
        })?;
        for name in pattern.names() {
            if !COMMON.contains(&name) && !map.axes.contains_key(name) {
                let known = COMMON.into_iter();
                let known = known.chain(map.axes.keys().map(String::as_str));
                let problem = DocumentProblem::unknown_name("field", name, known);
                return Err(map.refused(&field, problem));
            }
        }
        let cell = cell(map, names, &format!("split[{index}].column"), &split.column)?;
        splits.push((cell, pattern));
    }
    Ok(splits)
}

/// Finds where the map says a column is.
pub(crate) struct Finder<'m> {
    pub(crate) map: &'m Map,
    pub(crate) names: Names<'m>,
    pub(crate) splits: Vec<SplitCell>,
}

impl Finder<'_> {
    /// Where the column `name` of the table is, if anything says it.
    pub(crate) fn column(&self, name: &str) -> Result<Option<Source>, Error> {
        let nothing = ColumnMap::default();
        let column = self.map.columns.get(name).unwrap_or(&nothing);
        let field = format!("columns.{name}");
        self.source(&field, name, column.column.as_ref(), column.value.as_ref())
    }

    fn source(
        &self,
        field: &str,
        name: &str,
        column: Option<&ColumnName>,
        value: Option<&ColumnName>,
    ) -> Result<Option<Source>, Error> {
        let mut splits = self.splits.iter().enumerate();
        let part = splits.find_map(|(split, (_, pattern))| {
            let field = pattern.names().position(|field| field == name)?;
            Some(Source::Part { split, field })
        });
        match (column, value, part) {
            (Some(column), None, None) => {
                cell(self.map, self.names, field, column).map(|cell| Some(Source::Cell(cell)))
            }
            (None, Some(value), None) => Ok(Some(Source::Value(value.text()))),
            (None, None, part) => Ok(part),
            _ => Err(self.map.wrong(
                field,
                "more than one of column, value and pattern tells it",
                "one of them",
            )),
        }
    }

    /// The axes in the order of their names.
    pub(crate) fn axes(&self, path: &[PlannedStop<'_>]) -> Result<Vec<AxisColumn>, Error> {
        let map = self.map;
        if map.axes.is_empty() {
            let example = "a table [axes] with each axis of the machine, as X = { column = \"X\", unit = \"mm\" }";
            return Err(map.nothing("positions of the axes", example));
        }
        let legs = path.iter().map(|stop| stop.leg);
        let moving = legs.flat_map(|leg| leg.at.keys().chain([&leg.axis]));
        for axis in moving {
            if !map.axes.contains_key(axis) {
                let problem = DocumentProblem::unknown_name("axis", axis, map.axes.keys());
                return Err(map.refused("stops.path", problem));
            }
        }
        let mut axes = Vec::new();
        for (name, axis) in &map.axes {
            let field = format!("axes.{name}");
            let of = [Quantity::Length, Quantity::Angle];
            let source = self.source(&field, name, axis.column.as_ref(), axis.value.as_ref())?;
            if source.is_none() && path.is_empty() {
                return Err(map.wrong(
                    &field,
                    "nothing tells where it stands",
                    "column = \"…\", value = 0, a pattern, or a path below [stops]",
                ));
            }
            axes.push(AxisColumn {
                name: name.clone(),
                source,
                unit: map.unit(&field, axis.unit.as_deref(), &of)?,
            });
        }
        Ok(axes)
    }

    /// What was measured, and what was logged beside it.
    pub(crate) fn numbers(&self, kind: Kind) -> Result<Vec<NumberColumn>, Error> {
        let map = self.map;
        let required: &[&str] = match kind {
            Kind::Lengths => &[LENGTH],
            Kind::Points => &COORDINATES,
        };
        let mut numbers = Vec::new();
        for &name in required {
            let Some(source) = self.column(name)? else {
                let example =
                    format!("{name} = {{ column = \"…\", unit = \"mm\" }} below [columns]");
                return Err(map.nothing(name, &example));
            };
            numbers.push(NumberColumn {
                name: name.to_owned(),
                source,
                unit: Some(map.unit_of_column(name, &[Quantity::Length])?),
                optional: false,
            });
        }
        for name in map.columns.keys() {
            let unit = match (kind, name.as_str()) {
                (Kind::Points, SIGMA) => {
                    let unit = map.unit_of_column(name, &[Quantity::Length])?;
                    Some(Unit {
                        size: unit.size * MICROMETRES,
                        ..unit
                    })
                }
                (Kind::Lengths, name) if is_logged(name) => None,
                _ => continue,
            };
            if let Some(source) = self.column(name)? {
                numbers.push(NumberColumn {
                    name: name.clone(),
                    source,
                    unit,
                    optional: true,
                });
            }
        }
        Ok(numbers)
    }
}

/// The cell, from 0, of a column by name or number.
fn cell(map: &Map, names: Names<'_>, field: &str, column: &ColumnName) -> Result<usize, Error> {
    let (name, number) = match column {
        ColumnName::Name(name) => (name.as_str(), None),
        ColumnName::Number(number) => ("", Some(*number)),
        ColumnName::Value(value) => {
            return Err(map.wrong(
                field,
                format!("found {value}"),
                "a name or a whole number from 1",
            ));
        }
    };
    match (number, names) {
        (Some(0), _) => Err(map.wrong(field, "found 0", "columns are counted from 1")),
        (Some(number), _) => Ok(number - 1),
        (None, None) => Err(Problem::NoNames {
            name: name.to_owned(),
        }
        .at(map.place(field))),
        (None, Some((line, names))) => {
            let place = names.iter().position(|known| known == name);
            place.ok_or_else(|| {
                Problem::NoSuchColumn {
                    name: name.to_owned(),
                    line,
                    alternatives: Alternatives::new(name, names),
                }
                .at(map.place(field))
            })
        }
    }
}
