//! Tables of point checks: measured deviations of the tool at single places.

use std::path::Path;

use trueaxis_kinematics::Machine;

use crate::axis_columns::AxisColumns;
use crate::document::{VerificationEntry, VerificationKindEntry};
use crate::point_columns::{POINT_COLUMNS, PointColumns};
use crate::rows::{Rows, position_cells};
use crate::setup::axis_names;
use crate::table::Table;
use crate::{Error, Place, PointCheck, PointCheckReading, Problem};

/// Columns of the deviations, of which at least one is there.
pub(crate) const DEVIATION_COLUMNS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];

const WHEN_COLUMNS: [&str; 2] = ["time_s", "cycle"];

/// Reads the table of `entry`.
pub(crate) fn read(
    file: &Path,
    text: &str,
    entry: &VerificationEntry,
    machine: &Machine,
) -> Result<PointCheck, Error> {
    let optional: Vec<&str> = [&WHEN_COLUMNS[..], &POINT_COLUMNS, &DEVIATION_COLUMNS].concat();
    let mut table = Table::open(file, text, &axis_names(machine), &optional)?;
    let [time, cycle] = WHEN_COLUMNS.map(|name| table.optional_column(name));
    let point = PointColumns::of(&table)?;
    let mut axes = AxisColumns::of(&table, machine)?;
    let deviations = DEVIATION_COLUMNS.map(|name| table.optional_column(name));
    if deviations.iter().all(Option::is_none) {
        table.column(DEVIATION_COLUMNS[0])?;
    }

    let readings = table.read_rows(|row| {
        let positions = axes.read_within_travel(row)?;
        let [x, y, z] = deviations.map(|column| row.optional_number(column));
        let deviation_um = [x?, y?, z?];
        if deviation_um.iter().all(Option::is_none) {
            let expected =
                "a number in at least one of dx_um, dy_um, dz_um; remove the row if there is none";
            return Err(Problem::value("no deviation was measured", expected)
                .at(Place::line(file, row.line())));
        }
        Ok(PointCheckReading {
            time_s: time.map(|column| row.time_s(column)).transpose()?,
            cycle: cycle
                .map(|column| row.counting_number(column))
                .transpose()?,
            positions,
            tool_home_mm: point.read(row)?,
            deviation_um,
            line: row.line(),
        })
    })?;
    Ok(PointCheck {
        name: entry.name.clone(),
        u_um: entry.u_um,
        u_ppm: entry.u_ppm,
        readings,
    })
}

/// The text that [`read`] reads as `check`.
pub(crate) fn text(check: &PointCheck, machine: &Machine) -> String {
    let has = |is_there: fn(&PointCheckReading) -> bool| check.readings.iter().any(is_there);
    let has_time = has(|r| r.time_s.is_some());
    let has_cycle = has(|r| r.cycle.is_some());
    let has_point = has(|r| r.tool_home_mm.is_some());
    let [time, cycle] = WHEN_COLUMNS;
    let columns = has_time.then_some(time).into_iter();
    let columns = columns.chain(has_cycle.then_some(cycle));
    let columns = columns.chain(axis_names(machine));
    let columns = columns.chain(POINT_COLUMNS.into_iter().filter(|_| has_point));
    let mut rows = Rows::with_header(columns.chain(DEVIATION_COLUMNS));
    for reading in &check.readings {
        if has_time {
            rows.optional_time_s(reading.time_s);
        }
        if has_cycle {
            rows.optional(reading.cycle);
        }
        rows.positions(&position_cells(machine, &reading.positions));
        if has_point {
            let point = reading.tool_home_mm;
            (0..3).for_each(|c| rows.optional(point.map(|point| point[c])));
        }
        for deviation_um in reading.deviation_um {
            rows.optional(deviation_um);
        }
        rows.end_row();
    }
    rows.into_text()
}

/// The entry that belongs to the table in the file `readings`.
pub(crate) fn to_entry(check: &PointCheck, readings: String) -> VerificationEntry {
    VerificationEntry {
        name: check.name.clone(),
        kind: VerificationKindEntry::Points,
        u_um: check.u_um,
        u_ppm: check.u_ppm,
        readings,
        ..VerificationEntry::default()
    }
}
