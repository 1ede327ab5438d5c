//! The columns of axis positions: mm or degrees, within the travel.

use trueaxis_kinematics::{Axis, AxisKind, Machine};

use crate::table::{Column, Row, Table};
use crate::{Error, Problem, position_unit};

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

pub(crate) struct AxisColumns<'a> {
    axes: Vec<AxisColumn<'a>>,
}

struct AxisColumn<'a> {
    column: Column,
    axis: &'a Axis,
    /// The last cell that was read, and the position that it holds: few rows move an axis.
    cell: Vec<u8>,
    position: f64,
}

impl<'a> AxisColumns<'a> {
    pub(crate) fn of(table: &Table<'_>, machine: &'a Machine) -> Result<Self, Error> {
        let axes = machine.axes().iter();
        let columns = axes.map(|axis| {
            Ok(AxisColumn {
                column: table.column(axis.name())?,
                axis,
                cell: Vec::new(),
                position: 0.0,
            })
        });
        Ok(Self {
            axes: columns.collect::<Result<_, Error>>()?,
        })
    }

    /// Reads the positions of all axes into `positions`, mm or rad.
    pub(crate) fn read(&mut self, row: &Row<'_>, positions: &mut Vec<f64>) -> Result<(), Error> {
        positions.clear();
        for known in &mut self.axes {
            let cell = row.cell(known.column);
            if known.cell.is_empty() || known.cell != cell {
                let number = row.number(known.column)?;
                known.position = known.axis.kind().position_from_file(number);
                known.cell.clear();
                known.cell.extend_from_slice(cell);
            }
            positions.push(known.position);
        }
        Ok(())
    }

    /// The positions of all axes, which are within the travel, mm or rad.
    pub(crate) fn read_within_travel(&mut self, row: &Row<'_>) -> Result<Vec<f64>, Error> {
        let mut positions = Vec::with_capacity(self.axes.len());
        self.read(row, &mut positions)?;
        self.check_travel(row, &positions)?;
        Ok(positions)
    }

    pub(crate) fn check_travel(&self, row: &Row<'_>, positions: &[f64]) -> Result<(), Error> {
        for (known, &position) in self.axes.iter().zip(positions) {
            let &AxisColumn { column, axis, .. } = known;
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
                return Err(Problem::OutsideTravel {
                    position: position_unit::in_file(kind, position),
                    low: position_unit::in_file(kind, low),
                    high: position_unit::in_file(kind, high),
                    unit: kind.position_unit(),
                    hint: if micrometres {
                        "it looks like um: divide the column by 1000"
                    } else {
                        "correct the position, or the `travel` of the axis"
                    },
                }
                .at(row.place(column)));
            }
        }
        Ok(())
    }
}
