//! `lengths.csv`: one interferometer length per row.

use std::path::Path;

use rayon::prelude::*;

use crate::reading::readings_of;
use crate::rows::Rows;
use crate::steps::Steps;
use crate::table::{Column, Row, Table};
use crate::visits::{Sighting, VisitRows, Visits, append, required_columns};
use crate::{Campaign, Environment, Error, LengthReading, Lengths, Stop};

/// Columns of air and machine state, in the order of [`Environment`].
const ENVIRONMENT_COLUMNS: [&str; 4] = [
    "air_temp_c",
    "air_pressure_hpa",
    "air_humidity_pct",
    "machine_temp_c",
];

/// Columns before those of the axes.
const FIRST_COLUMNS: [&str; 5] = ["time_s", "station", "repeat", "run", "direction"];

/// Columns after those of the axes.
const LAST_COLUMNS: [&str; 2] = ["target", "length_mm"];

/// Reads the lengths and the steps in them. `campaign` knows all names.
pub(crate) fn read(
    file: &Path,
    text: &str,
    campaign: &Campaign,
) -> Result<(Lengths, Steps), Error> {
    let required = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    let table = Table::open(file, text, &required, &ENVIRONMENT_COLUMNS)?;
    let no_rows = table.no_rows();
    let pieces: Vec<Result<Piece, Error>> = table
        .pieces()
        .into_par_iter()
        .map(|table| read_piece(table, campaign))
        .collect();
    let mut all = Piece::default();
    for piece in pieces {
        let piece = piece?;
        append(&mut all.visits, piece.visits, all.readings.len());
        all.readings.extend(piece.readings);
        all.environment.extend(piece.environment);
    }
    if all.readings.is_empty() {
        return Err(no_rows);
    }
    let (stops, steps) = all.visits;
    let lengths = Lengths {
        stops,
        readings: all.readings,
        environment: Some(all.environment).filter(|environment| !environment.is_empty()),
    };
    Ok((lengths, steps))
}

/// What some of the rows hold.
#[derive(Default)]
struct Piece {
    visits: (Vec<Stop>, Steps),
    readings: Vec<LengthReading>,
    /// Of every reading, or nothing if the file has no such column.
    environment: Vec<Environment>,
}

fn read_piece(mut table: Table<'_>, campaign: &Campaign) -> Result<Piece, Error> {
    let mut visits = Visits::of(&table, campaign)?;
    let length = table.column("length_mm")?;
    let state = ENVIRONMENT_COLUMNS.map(|name| table.optional_column(name));
    let has_state = state.iter().any(Option::is_some);
    let mut readings = Vec::new();
    let mut environment = Vec::new();
    while let Some(row) = table.next_row()? {
        let sighting = visits.read(&row, readings.len())?;
        readings.push(LengthReading {
            time_s: sighting.time_s,
            target: sighting.target,
            length_mm: row.number(length)?,
            line: row.line(),
        });
        if has_state {
            environment.push(read_environment(&row, state)?);
        }
    }
    Ok(Piece {
        visits: visits.finish(),
        readings,
        environment,
    })
}

fn read_environment(row: &Row<'_>, state: [Option<Column>; 4]) -> Result<Environment, Error> {
    let [air_temp, air_pressure, air_humidity, machine_temp] = state;
    Ok(Environment {
        air_temp_c: row.optional_number(air_temp)?,
        air_pressure_hpa: row.optional_number(air_pressure)?,
        air_humidity_pct: row.optional_number(air_humidity)?,
        machine_temp_c: row.optional_number(machine_temp)?,
    })
}

/// The text that [`read`] reads as `lengths`.
pub(crate) fn text(campaign: &Campaign, lengths: &Lengths) -> String {
    let environment = lengths.environment.as_deref();
    let state_columns = state_columns(environment);
    let mut columns = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    columns.extend(state_columns.iter().map(|&(name, _)| name));
    let mut rows = Rows::with_header(columns);
    let visits = VisitRows::of(campaign);
    for stop in &lengths.stops {
        let readings = readings_of(stop, &lengths.readings);
        for (index, reading) in stop.readings.clone().zip(readings) {
            let sighting = Sighting {
                time_s: reading.time_s,
                target: reading.target,
            };
            visits.start_row(&mut rows, stop, &sighting, true);
            rows.length_mm(reading.length_mm);
            let state = environment.and_then(|e| e.get(index));
            for (_, value) in &state_columns {
                rows.optional_number(state.and_then(value));
            }
            rows.end_row();
        }
    }
    rows.into_text()
}

/// A column of air or machine state, and how to get its value.
type StateColumn = (&'static str, fn(&Environment) -> Option<f64>);

/// The columns that hold a value; if none does but the campaign has the state, the first.
fn state_columns(environment: Option<&[Environment]>) -> Vec<StateColumn> {
    let Some(environment) = environment else {
        return Vec::new();
    };
    let values: [fn(&Environment) -> Option<f64>; 4] = [
        |state| state.air_temp_c,
        |state| state.air_pressure_hpa,
        |state| state.air_humidity_pct,
        |state| state.machine_temp_c,
    ];
    let all = || ENVIRONMENT_COLUMNS.into_iter().zip(values);
    let holds_a_value = |(_, value): &StateColumn| environment.iter().any(|s| value(s).is_some());
    let mut columns: Vec<StateColumn> = all().filter(holds_a_value).collect();
    if columns.is_empty() {
        columns.extend(all().next());
    }
    columns
}
