//! Notices about readings that were compared with predictions.

use trueaxis_files::{round, told_behind};
use trueaxis_predict::{CalibratedMachine, position_in_file};

use crate::Verified;

/// Axes outside their calibrated steps, and single places that are far off all others; `is_compensated` as in [`crate::verify()`].
pub fn verify_notices(
    machine: &CalibratedMachine,
    verified: &[Verified],
    is_compensated: bool,
) -> Vec<String> {
    let outside = verified
        .iter()
        .filter_map(|entry| outside_steps(machine, entry));
    let far_off = verified
        .iter()
        .filter_map(|entry| far_off(machine, entry, is_compensated));
    outside.chain(far_off).collect()
}

fn outside_steps(machine: &CalibratedMachine, entry: &Verified) -> Option<String> {
    let points = entry.points.iter();
    let count = points
        .filter(|point| !machine.is_within_steps(&point.positions))
        .count();
    (count > 0).then(|| {
        format!(
            "{}: at {count} of its {} places an axis stands outside its calibrated steps; its errors there are those of the nearest step, \
             with a larger u",
            entry.name,
            entry.points.len()
        )
    })
}

fn far_off(machine: &CalibratedMachine, entry: &Verified, is_compensated: bool) -> Option<String> {
    let (point, off_um) = entry.far_off(is_compensated)?;
    let is_elsewhere = |axis: usize| {
        let mut others = entry.points.iter().map(|other| other.positions[axis]);
        others.any(|at| at.total_cmp(&point.positions[axis]).is_ne())
    };
    let axes = machine
        .machine()
        .axes()
        .iter()
        .zip(&point.positions)
        .enumerate();
    let moving = axes.filter(|(axis, _)| is_elsewhere(*axis));
    let at = moving.map(|(_, (axis, at))| {
        let unit = told_behind(axis.kind().position_unit(), ' ');
        format!(
            "{} = {}{unit}",
            axis.name(),
            round(position_in_file(axis.kind(), *at), 4)
        )
    });
    let at: Vec<String> = at.collect();
    // Point checks are not diagnosed.
    let hint = match entry.kind {
        Some(_) => " `trueaxis diagnose --calibration` names its line",
        None => "",
    };
    Some(format!(
        "{}: at {} the difference from the prediction is {off_um:+.1} µm apart from that of all other places, and shifts the zero of these: is a \
         reading mistyped?{hint}",
        entry.name,
        at.join(", ")
    ))
}
