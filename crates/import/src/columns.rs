//! Where each column of the table is in an export.

use trueaxis_files::{Alternatives, DocumentProblem};

use crate::import::Kind;
use crate::map::{ColumnMap, ColumnName, Map};
use crate::path::PlannedStop;
use crate::pattern::Pattern;
use crate::unit::{Quantity, Unit};
use crate::{Error, Problem};

/// Columns of both tables that are names or numbers of visits.
const COMMON: [&str; 6] = ["time_s", "station", "run", "repeat", "direction", "target"];

/// The columns that only one of the tables has.
pub(crate) const COORDINATES: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
pub(crate) const LENGTH: &str = "length_mm";
pub(crate) const SIGMA: &str = "sigma_um";

/// Logged quantities, taken as they are.
const LOGGED: [&str; 4] = [
    "air_temp_c",
    "air_pressure_hpa",
    "air_humidity_pct",
    "machine_temp_c",
];

/// µm in a mm.
const MICROMETRES: f64 = 1e3;

/// Where a value comes from.
#[derive(Debug, Clone)]
pub(crate) enum Source {
    /// A cell of the row, from 0.
    Cell(usize),
    /// The same in all rows.
    Value(String),
    /// A part of a cell.
    Part { split: usize, field: usize },
}

/// A number of a row.
#[derive(Debug)]
pub(crate) struct NumberColumn {
    pub(crate) name: String,
    pub(crate) source: Source,
    /// None for what is taken as it is.
    pub(crate) unit: Option<Unit>,
    /// Whether the cell may be empty.
    pub(crate) optional: bool,
}

/// An axis, and where its position comes from; none if the path tells it.
#[derive(Debug)]
pub(crate) struct AxisColumn {
    pub(crate) name: String,
    pub(crate) source: Option<Source>,
    pub(crate) unit: Unit,
}

/// All that is read of a row.
#[derive(Debug)]
pub(crate) struct Columns {
    pub(crate) station: Option<Source>,
    pub(crate) run: Option<Source>,
    pub(crate) target: Option<Source>,
    pub(crate) repeat: Option<Source>,
    pub(crate) direction: Option<Source>,
    pub(crate) time: Option<(Source, Unit)>,
    pub(crate) axes: Vec<AxisColumn>,
    pub(crate) numbers: Vec<NumberColumn>,
    /// Cells with several things, from 0, and what they are made of.
    pub(crate) splits: Vec<(usize, Pattern)>,
}

/// The names of the columns of an export and their line; none if they have only numbers.
pub(crate) type Names<'n> = Option<(usize, &'n [String])>;

impl Columns {
    /// The columns that `map` names, found among `names`.
    pub(crate) fn new(
        kind: Kind,
        map: &Map,
        names: Names<'_>,
        path: &[PlannedStop],
    ) -> Result<Self, Error> {
        check_known(map)?;
        let finder = Finder {
            map,
            names,
            splits: splits(map, names)?,
        };
        let time = match finder.column("time_s")? {
            None => None,
            Some(source) => {
                let name = map.columns.get("time_s").and_then(|c| c.unit.as_deref());
                let of = [Quantity::Time, Quantity::Clock];
                Some((source, map.unit("columns.time_s", name, &of)?))
            }
        };
        let mut columns = Self {
            station: finder.column("station")?,
            run: finder.column("run")?,
            target: finder.column("target")?,
            repeat: finder.column("repeat")?,
            direction: finder.column("direction")?,
            time,
            axes: finder.axes(path)?,
            numbers: finder.numbers(kind)?,
            splits: Vec::new(),
        };
        columns.splits = finder
            .splits
            .into_iter()
            .map(|(cell, pattern, _)| (cell, pattern))
            .collect();
        let nothing = |name: &str, example: &str| {
            let (name, example) = (name.to_owned(), example.to_owned());
            Err(Problem::Nothing { name, example }.at(map.whole()))
        };
        if kind == Kind::Lengths && columns.station.is_none() {
            return nothing("station", "station = { value = \"S1\" } below [columns]");
        }
        let has_order = |stop: &PlannedStop| !stop.targets.is_empty();
        let all_have_order = !path.is_empty() && path.iter().all(has_order);
        if columns.target.is_none() && map.stops.targets.is_empty() && !all_have_order {
            return nothing(
                "target",
                "target = { column = \"Point\" } below [columns], or targets = [\"P\", \"Q\", \"K\"], the order at each \
                 stop, below [stops]",
            );
        }
        if columns.run.is_none() && path.is_empty() {
            return nothing(
                "run",
                "run = { value = \"x\" } below [columns], or a path below [stops]",
            );
        }
        Ok(columns)
    }

    /// Number of cells that a row needs.
    pub(crate) fn needed(&self) -> usize {
        self.cells().max().map_or(0, |last| last + 1)
    }

    /// All cells that are read, from 0.
    pub(crate) fn cells(&self) -> impl Iterator<Item = usize> {
        let names = [
            &self.station,
            &self.run,
            &self.target,
            &self.repeat,
            &self.direction,
        ];
        let names = names.into_iter().flatten();
        let axes = self.axes.iter().filter_map(|axis| axis.source.as_ref());
        let numbers = self.numbers.iter().map(|number| &number.source);
        let time = self.time.iter().map(|(source, _)| source);
        let cells =
            names
                .chain(axes)
                .chain(numbers)
                .chain(time)
                .filter_map(|source| match source {
                    Source::Cell(cell) => Some(*cell),
                    _ => None,
                });
        cells.chain(self.splits.iter().map(|(cell, _)| *cell))
    }
}

/// Refuses columns that no table has.
fn check_known(map: &Map) -> Result<(), Error> {
    let known = COMMON
        .iter()
        .chain(&COORDINATES)
        .chain([&LENGTH, &SIGMA])
        .chain(&LOGGED);
    let known: Vec<&str> = known.copied().collect();
    for name in map.columns.keys() {
        if !known.contains(&name.as_str()) && !is_logged(name) {
            let problem = DocumentProblem::UnknownName {
                what: "column of the table",
                name: name.clone(),
                alternatives: Alternatives::new(name, &known),
            };
            return Err(Problem::Document(problem).at(map.place(&format!("columns.{name}"))));
        }
    }
    Ok(())
}

/// Whether a column is a logged quantity: one of the fixed ones or `machine_temp_<name>_c`.
fn is_logged(name: &str) -> bool {
    let is_temperature = || name.starts_with("machine_temp_") && name.ends_with("_c");
    LOGGED.contains(&name) || is_temperature()
}

/// A cell of the map's `split` with its pattern and the field in the map.
type SplitCell = (usize, Pattern, String);

fn splits(map: &Map, names: Names<'_>) -> Result<Vec<SplitCell>, Error> {
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
                let problem = DocumentProblem::UnknownName {
                    what: "field",
                    name: name.to_owned(),
                    alternatives: Alternatives::new(
                        name,
                        COMMON
                            .into_iter()
                            .chain(map.axes.keys().map(String::as_str)),
                    ),
                };
                return Err(Problem::Document(problem).at(map.place(&field)));
            }
        }
        let cell = cell(map, names, &format!("split[{index}].column"), &split.column)?;
        splits.push((cell, pattern, field));
    }
    Ok(splits)
}

struct Finder<'m> {
    map: &'m Map,
    names: Names<'m>,
    splits: Vec<SplitCell>,
}

impl Finder<'_> {
    /// Where the column `name` of the table is, if anything says it.
    fn column(&self, name: &str) -> Result<Option<Source>, Error> {
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
        let part = self
            .splits
            .iter()
            .enumerate()
            .find_map(|(split, (_, pattern, _))| {
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

    fn axes(&self, path: &[PlannedStop]) -> Result<Vec<AxisColumn>, Error> {
        let map = self.map;
        if map.axes.is_empty() {
            return Err(Problem::Nothing {
                name: "positions of the axes".to_owned(),
                example: "a table [axes] with each axis of the machine, as X = { column = \"X\", unit = \"mm\" }".to_owned(),
            }
            .at(map.whole()));
        }
        let moving = path.iter().flat_map(|stop| {
            let others = stop.at.iter().map(|(axis, _)| axis);
            others.chain([&stop.axis])
        });
        for axis in moving {
            if !map.axes.contains_key(axis) {
                let problem = DocumentProblem::UnknownName {
                    what: "axis",
                    name: axis.clone(),
                    alternatives: Alternatives::new(axis, map.axes.keys()),
                };
                return Err(Problem::Document(problem).at(map.place("stops.path")));
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
                unit: map.unit(&field, Some(&axis.unit), &of)?,
            });
        }
        Ok(axes)
    }

    /// What was measured, and what was logged beside it.
    fn numbers(&self, kind: Kind) -> Result<Vec<NumberColumn>, Error> {
        let map = self.map;
        let required: &[&str] = match kind {
            Kind::Lengths => &[LENGTH],
            Kind::Points => &COORDINATES,
        };
        let mut numbers = Vec::new();
        for &name in required {
            let Some(source) = self.column(name)? else {
                let unit = "mm";
                let example =
                    format!("{name} = {{ column = \"…\", unit = \"{unit}\" }} below [columns]");
                let name = name.to_owned();
                return Err(Problem::Nothing { name, example }.at(map.whole()));
            };
            let unit = map
                .columns
                .get(name)
                .and_then(|column| column.unit.as_deref());
            let unit = map.unit(&format!("columns.{name}"), unit, &[Quantity::Length])?;
            let (name, unit, optional) = (name.to_owned(), Some(unit), false);
            numbers.push(NumberColumn {
                name,
                source,
                unit,
                optional,
            });
        }
        for (name, column) in &map.columns {
            let unit = match (kind, name.as_str()) {
                (Kind::Points, SIGMA) => {
                    let field = format!("columns.{name}");
                    let unit = map.unit(&field, column.unit.as_deref(), &[Quantity::Length])?;
                    Some(Unit {
                        size: unit.size * MICROMETRES,
                        ..unit
                    })
                }
                (Kind::Lengths, name) if is_logged(name) => None,
                _ => continue,
            };
            if let Some(source) = self.column(name)? {
                let (name, optional) = (name.clone(), true);
                numbers.push(NumberColumn {
                    name,
                    source,
                    unit,
                    optional,
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
