//! Where each column of the table is in an export.

use trueaxis_files::DocumentProblem;

use crate::Error;
use crate::finder::{Finder, SplitCell, splits};
use crate::import::Kind;
use crate::map::Map;
use crate::path::PlannedStop;
use crate::unit::{Quantity, Unit};

/// Columns of both tables that are names or numbers of visits.
pub(crate) const COMMON: [&str; 6] = ["time_s", "station", "run", "repeat", "direction", "target"];

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
    pub(crate) splits: Vec<SplitCell>,
}

/// The names of the columns of an export and their line; none if they have only numbers.
pub(crate) type Names<'n> = Option<(usize, &'n [String])>;

impl Columns {
    /// The columns that `map` names, found among `names`.
    pub(crate) fn new(
        kind: Kind,
        map: &Map,
        names: Names<'_>,
        path: &[PlannedStop<'_>],
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
                let of = [Quantity::Time, Quantity::Clock];
                Some((source, map.unit_of_column("time_s", &of)?))
            }
        };
        let columns = Self {
            station: finder.column("station")?,
            run: finder.column("run")?,
            target: finder.column("target")?,
            repeat: finder.column("repeat")?,
            direction: finder.column("direction")?,
            time,
            axes: finder.axes(path)?,
            numbers: finder.numbers(kind)?,
            splits: finder.splits,
        };
        let nothing = |name, example| Err(map.nothing(name, example));
        if kind == Kind::Lengths && columns.station.is_none() {
            return nothing("station", "station = { value = \"S1\" } below [columns]");
        }
        let has_order = |stop: &PlannedStop<'_>| !stop.leg.targets.is_empty();
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
        let sources = names.chain(axes).chain(numbers).chain(time);
        let cells = sources.filter_map(|source| match source {
            Source::Cell(cell) => Some(*cell),
            _ => None,
        });
        cells.chain(self.splits.iter().map(|(cell, _)| *cell))
    }
}

/// Refuses columns that no table has.
fn check_known(map: &Map) -> Result<(), Error> {
    let known = [&COMMON[..], &COORDINATES, &[LENGTH, SIGMA], &LOGGED].concat();
    for name in map.columns.keys() {
        if !known.contains(&name.as_str()) && !is_logged(name) {
            let problem = DocumentProblem::unknown_name("column of the table", name, known);
            return Err(map.refused(&format!("columns.{name}"), problem));
        }
    }
    Ok(())
}

/// Whether a column is a logged quantity: one of the fixed ones or `machine_temp_<name>_c`.
pub(crate) fn is_logged(name: &str) -> bool {
    let is_temperature = || name.starts_with("machine_temp_") && name.ends_with("_c");
    LOGGED.contains(&name) || is_temperature()
}
