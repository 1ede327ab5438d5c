//! A table of places: positions of all axes, and of the point on the tool.

use std::path::Path;

use nalgebra::Point3;
use trueaxis_kinematics::Machine;

use crate::axis_columns::AxisColumns;
use crate::point_columns::{POINT_COLUMNS, PointColumns};
use crate::setup::axis_names;
use crate::table::Table;
use crate::{Error, text_file};

/// Where a machine stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Position {
    /// Line of the file, from 1 (the header).
    pub line: usize,
    /// Commanded positions of all axes, mm or rad.
    pub axes: Vec<f64>,
    /// A point on the last stage, in the reference frame at home, mm; `None` if the table has no columns for it.
    pub point_mm: Option<Point3<f64>>,
}

/// Reads a table of positions: one column for each axis of the machine (mm, degrees), optionally `x_mm,y_mm,z_mm`.
///
/// # Errors
/// With row and column: what was found, what is expected; a position outside the travel of its axis is wrong.
pub fn read_positions(file: &Path, machine: &Machine) -> Result<Vec<Position>, Error> {
    let text = text_file::read(file, "give the path of a table of positions")?;
    let required = axis_names(machine);
    let mut table = Table::open(file, &text, &required, &POINT_COLUMNS)?;
    let mut columns = AxisColumns::of(&table, machine)?;
    let point = PointColumns::of(&table)?;
    table.read_rows(|row| {
        Ok(Position {
            line: row.line(),
            axes: columns.read_within_travel(row)?,
            point_mm: point.read(row)?,
        })
    })
}
