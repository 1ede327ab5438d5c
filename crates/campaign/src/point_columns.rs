//! The columns of a point on the tool, which are all there or none is.

use nalgebra::Point3;

use crate::Error;
use crate::table::{Column, Row, Table};

/// Their names.
pub(crate) const POINT_COLUMNS: [&str; 3] = ["x_mm", "y_mm", "z_mm"];

/// The columns, if the table has them.
pub(crate) struct PointColumns(Option<[Column; 3]>);

impl PointColumns {
    /// Finds the columns in `table`; some without the others are an error.
    pub(crate) fn of(table: &Table<'_>) -> Result<Self, Error> {
        let mut names = POINT_COLUMNS.iter();
        if !names.any(|name| table.optional_column(name).is_some()) {
            return Ok(Self(None));
        }
        let [x, y, z] = POINT_COLUMNS.map(|name| table.column(name));
        Ok(Self(Some([x?, y?, z?])))
    }

    /// The point of a row, in the reference frame at home, mm.
    pub(crate) fn read(&self, row: &Row<'_>) -> Result<Option<Point3<f64>>, Error> {
        let Some([x, y, z]) = self.0 else {
            return Ok(None);
        };
        let [x, y, z] = [x, y, z].map(|column| row.number(column));
        Ok(Some(Point3::new(x?, y?, z?)))
    }
}
