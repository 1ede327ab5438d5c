//! The axis of each run must be the one that moves in it.

use std::path::Path;

use crate::axis_columns::tolerance;
use crate::steps::Steps;
use crate::{Campaign, Error, Place, Problem};

/// Refuses a run in which other axes move and its own never does. A run whose axis moves together
/// with others is fine, and so is one that holds a single position.
pub(crate) fn check(file: &Path, campaign: &Campaign, steps: &Steps) -> Result<(), Error> {
    let axes = campaign.machine.axes();
    for (index, run) in campaign.runs.iter().enumerate() {
        let mut first: Option<&[f64]> = None;
        let mut moved_in_line = vec![None; axes.len()];
        for (step, &line) in steps.steps.iter().zip(&steps.lines) {
            if step.run != Some(index) {
                continue;
            }
            let start = first.get_or_insert(&step.positions);
            let positions = start.iter().zip(&step.positions);
            for ((moved, axis), (start, now)) in moved_in_line.iter_mut().zip(axes).zip(positions) {
                if moved.is_none() && (now - start).abs() > tolerance(axis) {
                    *moved = Some(line);
                }
            }
        }
        let first_motion = moved_in_line.iter().flatten().min();
        if let (None, Some(&line)) = (moved_in_line[run.axis], first_motion) {
            let moving = axes.iter().zip(&moved_in_line);
            let moving = moving.filter(|(_, moved)| moved.is_some());
            return Err(Problem::WrongAxisMoves {
                run: run.name.clone(),
                axis: axes[run.axis].name().to_owned(),
                moving: moving.map(|(axis, _)| axis.name().to_owned()).collect(),
            }
            .at(Place::line(file, line)));
        }
    }
    Ok(())
}
