//! The columns of axis positions: mm or degrees, within the travel.

use trueaxis_kinematics::{Axis, AxisKind, Machine};

use crate::table::{Column, Row, Table};
use crate::{Error, position_unit};

/// Share of an axis' travel by which a position may exceed it: command values are rounded.
const TRAVEL_TOL: f64 = 1e-6;

/// The same for an axis whose travel has no length, mm or rad.
const TRAVEL_TOL_ABSOLUTE: f64 = 1e-9;

/// Positions this many times beyond the travel are more likely in another unit.
const FAR_BEYOND: f64 = 10.0;

/// How far two positions of an axis may differ and still be the same, mm or rad.
pub(crate) fn tolerance(axis: &Axis) -> f64 {
    let [low, high] = axis.travel();
    TRAVEL_TOL * (high - low) + TRAVEL_TOL_ABSOLUTE
}

/// One column for each axis of a machine.
pub(crate) struct AxisColumns<'a> {
    axes: Vec<(Column, &'a Axis)>,
}

impl<'a> AxisColumns<'a> {
    /// Finds the columns in `table`.
    pub(crate) fn of(table: &Table<'_>, machine: &'a Machine) -> Result<Self, Error> {
        let axes = machine.axes().iter();
        let columns = axes.map(|axis| Ok((table.column(axis.name())?, axis)));
        Ok(Self {
            axes: columns.collect::<Result<_, _>>()?,
        })
    }

    /// Reads the positions of all axes into `positions`, mm or rad.
    pub(crate) fn read(&self, row: &Row<'_>, positions: &mut Vec<f64>) -> Result<(), Error> {
        positions.clear();
        for &(column, axis) in &self.axes {
            positions.push(position_unit::from_file(axis.kind(), row.number(column)?));
        }
        Ok(())
    }

    /// Checks that `positions`, read from `row`, are within the travel.
    pub(crate) fn check_travel(&self, row: &Row<'_>, positions: &[f64]) -> Result<(), Error> {
        for (&(column, axis), &position) in self.axes.iter().zip(positions) {
            let [low, high] = axis.travel();
            let within = |position: f64| {
                let beyond = (low - position).max(position - high);
                beyond <= tolerance(axis)
            };
            if !within(position) {
                let kind = axis.kind();
                let far_beyond = position.abs() > FAR_BEYOND * low.abs().max(high.abs());
                let micrometres =
                    kind == AxisKind::Linear && far_beyond && within(position / 1000.0);
                return Err(Error::OutsideTravel {
                    place: row.place(column),
                    position: position_unit::in_file(kind, position),
                    low: position_unit::in_file(kind, low),
                    high: position_unit::in_file(kind, high),
                    unit: position_unit::unit(kind),
                    mend: if micrometres {
                        "it looks like um: divide the column by 1000"
                    } else {
                        "mend the position, or the travel in campaign.json"
                    },
                });
            }
        }
        Ok(())
    }
}
