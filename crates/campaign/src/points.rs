//! `points.csv`: one measured point per row, in the frame of any rigid 3D instrument.

use std::path::Path;

use nalgebra::Point3;

use crate::point_columns::POINT_COLUMNS;
use crate::steps::Steps;
use crate::stops::{self, StopReader, required_columns};
use crate::table::{Column, Row, Table};
use crate::{Campaign, Error, PointReading, Points, Problem, near_positions};

/// Columns before those of the axes.
const FIRST_COLUMNS: [&str; 4] = ["time_s", "repeat", "run", "direction"];

/// Columns after those of the axes.
pub(crate) const LAST_COLUMNS: [&str; 4] = ["target", "x_mm", "y_mm", "z_mm"];

/// The optional column.
pub(crate) const SIGMA_COLUMN: &str = "sigma_um";

/// Reads the points and the steps in them. `campaign` knows all names.
pub(crate) fn read(file: &Path, text: &str, campaign: &Campaign) -> Result<(Points, Steps), Error> {
    let required = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    let mut table = Table::open(file, text, &required, &[SIGMA_COLUMN])?;
    let mut reader = StopReader::of(&table, campaign)?;
    let [x, y, z] = POINT_COLUMNS.map(|name| table.column(name));
    let (x, y, z) = (x?, y?, z?);
    let sigma = table.optional_column(SIGMA_COLUMN);

    let readings = table.read_rows(|row| {
        let sighting = reader.read(row)?;
        Ok(PointReading {
            time_s: sighting.time_s,
            target: sighting.target,
            position_mm: Point3::new(row.number(x)?, row.number(y)?, row.number(z)?),
            sigma_um: read_sigma(row, sigma)?,
            line: sighting.line,
        })
    })?;
    let (stops, steps) = near_positions::join(&campaign.machine, reader.finish());
    Ok((Points { stops, readings }, steps))
}

fn read_sigma(row: &Row<'_>, column: Option<Column>) -> Result<Option<f64>, Error> {
    let sigma = row.optional_number(column)?;
    match (sigma, column) {
        (Some(sigma_um), Some(column)) if sigma_um <= 0.0 => Err(Problem::value(
            format!("a standard deviation of {sigma_um}"),
            "more than zero; leave the cell empty if it is not known",
        )
        .at(row.place(column))),
        _ => Ok(sigma),
    }
}

/// The text that [`read`] reads as `points`.
pub(crate) fn text(campaign: &Campaign, points: &Points) -> String {
    let has_sigma = points.readings.iter().any(|r| r.sigma_um.is_some());
    let mut columns = required_columns(&FIRST_COLUMNS, &campaign.machine, &LAST_COLUMNS);
    columns.extend(has_sigma.then_some(SIGMA_COLUMN));
    let rows = (&points.stops[..], &points.readings[..]);
    stops::text(campaign, columns, rows, |rows, _, reading| {
        reading.position_mm.iter().for_each(|&c| rows.number(c));
        if has_sigma {
            rows.optional(reading.sigma_um);
        }
    })
}
