//! The axis of each run, and of each line of a verification, must be the one that moves in it.

use std::path::Path;

use trueaxis_kinematics::Axis;

use crate::axis_columns::tolerance;
use crate::steps::Steps;
use crate::{Campaign, Error, Place, Problem};

/// Refuses a run in which other axes move and its own never does. A run whose axis moves together
/// with others is fine, and so is one that holds a single position.
pub(crate) fn check(file: &Path, campaign: &Campaign, steps: &Steps) -> Result<(), Error> {
    for (index, run) in campaign.runs.iter().enumerate() {
        let rows = steps.steps.iter().zip(&steps.lines);
        let rows = rows.filter(|(step, _)| step.run == Some(index));
        let rows = rows.map(|(step, &line)| (step.positions.as_slice(), line));
        let of = ("run", run.name.as_str());
        check_moves(file, campaign.machine.axes(), &[run.axis], of, rows)?;
    }
    Ok(())
}

/// The same for the rows, with their lines, of what has this kind and name: one of these axes must move, if any does.
pub(crate) fn check_moves<'a>(
    file: &Path,
    axes: &[Axis],
    own: &[usize],
    (kind, name): (&'static str, &str),
    mut rows: impl Iterator<Item = (&'a [f64], usize)>,
) -> Result<(), Error> {
    let Some((start, _)) = rows.next() else {
        return Ok(());
    };
    let mut moved_in_line = vec![None; axes.len()];
    for (positions, line) in rows {
        let positions = start.iter().zip(positions);
        for ((moved, axis), (start, now)) in moved_in_line.iter_mut().zip(axes).zip(positions) {
            if moved.is_none() && (now - start).abs() > tolerance(axis) {
                *moved = Some(line);
            }
        }
    }
    let first_motion = moved_in_line.iter().flatten().min();
    let own_moves = own.iter().any(|&axis| moved_in_line[axis].is_some());
    if let (false, Some(&line), Some(&axis)) = (own_moves, first_motion, own.last()) {
        let moving = axes.iter().zip(&moved_in_line);
        let moving = moving.filter(|(_, moved)| moved.is_some());
        return Err(Problem::WrongAxisMoves {
            kind,
            name: name.to_owned(),
            axis: axes[axis].name().to_owned(),
            moving: moving.map(|(axis, _)| axis.name().to_owned()).collect(),
        }
        .at(Place::line(file, line)));
    }
    Ok(())
}
