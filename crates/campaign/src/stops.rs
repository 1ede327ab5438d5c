//! The part of a row that `lengths.csv` and `points.csv` share: which target, when, at which stop.

use trueaxis_kinematics::Machine;

use crate::axis_columns::AxisColumns;
use crate::names::Names;
use crate::reading::{Reading, readings_of};
use crate::rows::{Rows, position_cells};
use crate::steps::Steps;
use crate::table::{Column, Row, Table};
use crate::{Campaign, Direction, Error, Problem, Sighting, Step, Stop};

/// Groups rows into stops and steps.
///
/// A stop is a maximal group of consecutive rows with the same station, repeat, run, direction
/// and positions of all axes. Targets on the bed are read beside the runs: their rows have neither run nor direction.
pub(crate) struct StopReader<'a> {
    time: Column,
    station: Option<(Column, Names<'a>)>,
    repeat: Column,
    run: (Column, Names<'a>),
    direction: Column,
    axes: AxisColumns<'a>,
    target: (Column, Names<'a>),
    /// Whether each target stands on the bed.
    is_on_bed: Vec<bool>,
    positions: Vec<f64>,
    stops: Vec<Stop>,
    steps: Steps,
}

/// The columns before and after those of the axes, in the order of the format.
pub(crate) fn required_columns<'a>(
    first: &[&'a str],
    machine: &'a Machine,
    last: &[&'a str],
) -> Vec<&'a str> {
    let axes = machine.axes().iter().map(|axis| axis.name());
    let first = first.iter().copied();
    first.chain(axes).chain(last.iter().copied()).collect()
}

impl<'a> StopReader<'a> {
    /// Finds the columns in `table`. Without a column `station`, the station is number 0.
    pub(crate) fn of(table: &Table<'_>, campaign: &'a Campaign) -> Result<Self, Error> {
        let stations = campaign.stations.iter().map(|s| s.name.as_str());
        let runs = campaign.runs.iter().map(|r| r.name.as_str());
        let targets = campaign.targets.iter().map(|t| t.name.as_str());
        let on_bed = campaign.targets.iter().map(|t| t.carrier.is_none());
        Ok(Self {
            time: table.column("time_s")?,
            station: table
                .optional_column("station")
                .map(|column| (column, Names::new("station", stations))),
            repeat: table.column("repeat")?,
            run: (table.column("run")?, Names::new("run", runs)),
            direction: table.column("direction")?,
            axes: AxisColumns::of(table, &campaign.machine)?,
            target: (table.column("target")?, Names::new("target", targets)),
            is_on_bed: on_bed.collect(),
            positions: Vec::new(),
            stops: Vec::new(),
            steps: Steps::default(),
        })
    }

    /// Reads the shared part of `row`, which is the next reading.
    pub(crate) fn read(&mut self, row: &Row<'_>) -> Result<Sighting, Error> {
        let time_s = row.time_s(self.time)?;
        let station = match &mut self.station {
            Some((column, names)) => row.name(*column, names)?,
            None => 0,
        };
        let repeat = row.counting_number(self.repeat)?;
        let target = row.name(self.target.0, &mut self.target.1)?;
        let is_on_bed = self.is_on_bed.get(target) == Some(&true);
        self.check_run(row, target, is_on_bed)?;
        let (run, direction) = match is_on_bed {
            true => (None, Direction::Forward),
            false => {
                let run = row.name(self.run.0, &mut self.run.1)?;
                (Some(run), row.direction(self.direction)?)
            }
        };
        self.axes.read(row, &mut self.positions)?;
        let step = match self.steps.find(run, &self.positions) {
            Some(step) => step,
            None => {
                self.axes.check_travel(row, &self.positions)?;
                self.steps.add(run, &self.positions, row.line())
            }
        };
        let reading = self.stops.last().map_or(0, |stop| stop.readings.end);
        let stop = Stop {
            station,
            repeat,
            step,
            direction,
            readings: reading..reading + 1,
        };
        stay_or_arrive(&mut self.stops, stop);
        Ok(Sighting {
            time_s,
            target,
            line: row.line(),
        })
    }

    /// A target that an axis carries is read in a run, one on the bed in none.
    fn check_run(&self, row: &Row<'_>, target: usize, is_on_bed: bool) -> Result<(), Error> {
        let columns = [
            (self.run.0, "run", "the name of its run"),
            (self.direction, "direction", "1 or -1"),
        ];
        let wrong = |column: &(Column, _, _)| row.cell(column.0).is_empty() != is_on_bed;
        let Some((column, name, what)) = columns.into_iter().find(wrong) else {
            return Ok(());
        };
        let cell = String::from_utf8_lossy(row.cell(column));
        let target = self.target.1.name(target);
        let (found, expected) = match is_on_bed {
            true => (
                format!(
                    "\"{cell}\" for target `{target}`, which stands on the bed (`carried_by` null)"
                ),
                format!(
                    "an empty cell: targets on the bed are read beside the runs; if an axis carries it, say \
                     which in `carried_by` ({name})"
                ),
            ),
            false => (
                format!("an empty cell for target `{target}`, which an axis carries"),
                format!("{what}; only targets on the bed (`carried_by` null) have none"),
            ),
        };
        Err(Problem::value(found, expected).at(row.place(column)))
    }

    pub(crate) fn finish(self) -> (Vec<Stop>, Steps) {
        (self.stops, self.steps)
    }
}

/// Appends what the next rows of a file hold, of which the first is reading number `first`.
pub(crate) fn append(
    (stops, steps): &mut (Vec<Stop>, Steps),
    (next_stops, next_steps): (Vec<Stop>, Steps),
    first: usize,
) {
    let next = next_steps.steps.iter().zip(next_steps.lines);
    let number = |(step, line): (&Step, usize)| match steps.find(step.run, &step.positions) {
        Some(number) => number,
        None => steps.add(step.run, &step.positions, line),
    };
    let numbers: Vec<usize> = next.map(number).collect();
    for stop in next_stops {
        let stop = Stop {
            step: numbers[stop.step],
            readings: first + stop.readings.start..first + stop.readings.end,
            ..stop
        };
        stay_or_arrive(stops, stop);
    }
}

impl Stop {
    /// What consecutive rows of one stop have in common.
    pub(crate) fn visit(&self) -> (usize, u32, usize, Direction) {
        (self.station, self.repeat, self.step, self.direction)
    }
}

/// Appends readings that follow, at the last stop or at a new one.
fn stay_or_arrive(stops: &mut Vec<Stop>, next: Stop) {
    match stops.last_mut() {
        Some(stop) if stop.visit() == next.visit() => stop.readings.end = next.readings.end,
        _ => stops.push(next),
    }
}

/// The text of a table that [`StopReader`] reads; `write_values` writes the cells behind `target` for a reading and its number.
pub(crate) fn text<R: Reading>(
    campaign: &Campaign,
    columns: Vec<&str>,
    (stops, readings): (&[Stop], &[R]),
    write_values: impl Fn(&mut Rows, usize, &R),
) -> String {
    let of_step = |step: &Step| position_cells(&campaign.machine, &step.positions);
    let positions: Vec<String> = campaign.steps.iter().map(of_step).collect();
    let mut rows = Rows::with_header(columns);
    for stop in stops {
        let positions = positions.get(stop.step).map(String::as_str);
        for (number, reading) in stop.readings.clone().zip(readings_of(stop, readings)) {
            start_row(&mut rows, campaign, stop, positions, reading);
            write_values(&mut rows, number, reading);
            rows.end_row();
        }
    }
    rows.into_text()
}

/// Writes the columns up to `target`. An index that points nowhere gives an empty name, which no reading accepts.
fn start_row<R: Reading>(
    rows: &mut Rows,
    campaign: &Campaign,
    stop: &Stop,
    positions: Option<&str>,
    reading: &R,
) {
    let station = campaign.stations.get(stop.station).map(|s| s.name.as_str());
    let step = campaign.steps.get(stop.step);
    let run = step.and_then(|step| campaign.runs.get(step.run?));
    let target = campaign.targets.get(reading.target());
    rows.time_s(reading.time_s());
    if R::HAS_STATION {
        rows.name(station.unwrap_or_default());
    }
    rows.number(stop.repeat);
    rows.name(run.map(|run| run.name.as_str()).unwrap_or_default());
    match run {
        Some(_) => rows.number(stop.direction.sign()),
        None => rows.name(""),
    }
    rows.positions(positions.unwrap_or_default());
    rows.name(target.map(|t| t.name.as_str()).unwrap_or_default());
}
