//! `lengths.csv`: one interferometer length per row.

use std::path::Path;

use rayon::prelude::*;

use crate::logged::LOGGED_COLUMNS;
use crate::steps::Steps;
use crate::stops::{self, StopReader, append, required_columns};
use crate::table::{Column, Table};
use crate::{
    Campaign, Error, LengthReading, Lengths, LoggedColumn, LoggedQuantity, Problem, Stop,
    near_positions,
};

/// Columns before those of the axes.
pub(crate) const FIRST_COLUMNS: [&str; 5] = ["time_s", "station", "repeat", "run", "direction"];

/// Columns after those of the axes.
pub(crate) const LAST_COLUMNS: [&str; 2] = ["target", "length_mm"];

/// Reads the lengths and the steps in them. `campaign` knows all names.
pub(crate) fn read(
    file: &Path,
    text: &str,
    campaign: &Campaign,
) -> Result<(Lengths, Steps), Error> {
    let required = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    let table = Table::open(file, text, &required, &LOGGED_COLUMNS)?;
    let no_rows = table.no_rows();
    let mut all = Chunk::of(&table);
    let chunks: Vec<Result<Chunk, Error>> = table
        .chunks()
        .into_par_iter()
        .map(|table| read_chunk(table, campaign))
        .collect();
    for chunk in chunks {
        let chunk = chunk?;
        append(&mut all.stops, chunk.stops, all.readings.len());
        all.readings.extend(chunk.readings);
        for ((_, column), (_, next)) in all.logged.iter_mut().zip(chunk.logged) {
            column.values.extend(next.values);
        }
    }
    if all.readings.is_empty() {
        return Err(no_rows);
    }
    let (stops, steps) = near_positions::join(&campaign.machine, all.stops);
    let lengths = Lengths {
        stops,
        readings: all.readings,
        logged: all.logged.into_iter().map(|(_, column)| column).collect(),
    };
    Ok((lengths, steps))
}

/// What some of the rows hold.
struct Chunk {
    stops: (Vec<Stop>, Steps),
    readings: Vec<LengthReading>,
    logged: Vec<(Column, LoggedColumn)>,
}

impl Chunk {
    /// No rows yet, with the logged columns of the table.
    fn of(table: &Table<'_>) -> Self {
        let logged = table.columns().filter_map(|(name, column)| {
            LoggedQuantity::of_column(name)?;
            let (name, values) = (name.to_owned(), Vec::new());
            Some((column, LoggedColumn { name, values }))
        });
        Self {
            stops: Default::default(),
            readings: Vec::new(),
            logged: logged.collect(),
        }
    }
}

fn read_chunk(mut table: Table<'_>, campaign: &Campaign) -> Result<Chunk, Error> {
    let mut chunk = Chunk::of(&table);
    let mut reader = StopReader::of(&table, campaign)?;
    let length = table.column("length_mm")?;
    while let Some(row) = table.next_row()? {
        let sighting = reader.read(&row)?;
        chunk.readings.push(LengthReading {
            time_s: sighting.time_s,
            target: sighting.target,
            length_mm: row.number(length)?,
            line: sighting.line,
        });
        for (column, logged) in &mut chunk.logged {
            let value = row.optional_number(Some(*column))?;
            if let (Some(value), Some(quantity)) = (value, logged.quantity()) {
                let refused = |problem: Problem| problem.at(row.place(*column));
                quantity.check(value).map_err(refused)?;
            }
            logged.values.push(value);
        }
    }
    chunk.stops = reader.finish();
    Ok(chunk)
}

/// The text that [`read`] reads as `lengths`.
pub(crate) fn text(campaign: &Campaign, lengths: &Lengths) -> String {
    let mut columns = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    columns.extend(lengths.logged.iter().map(|column| column.name.as_str()));
    let rows = (&lengths.stops[..], &lengths.readings[..]);
    stops::text(campaign, columns, rows, |rows, number, reading| {
        rows.length_mm(reading.length_mm);
        for column in &lengths.logged {
            rows.optional(column.values.get(number).copied().flatten());
        }
    })
}
