//! Steps, targets and lengths, described as in the campaign.

use trueaxis_campaign::{Campaign, Lengths, Stop};
use trueaxis_kinematics::AxisKind;

use crate::Error;

/// Number of targets of a stage that shows all six component errors of an axis.
pub const MIN_TARGETS: usize = 3;

/// A step as `run x at X = 40 mm, Y = 0 mm`, or as `the bed`.
pub fn step_in_words(campaign: &Campaign, step: usize) -> String {
    let step = &campaign.steps[step];
    let Some(run) = step.run else {
        return "the bed".to_owned();
    };
    let axes = campaign.machine.axes().iter().zip(&step.positions);
    let positions = axes.map(|(axis, &position)| match axis.kind() {
        AxisKind::Linear => format!("{} = {position} mm", axis.name()),
        // Degrees as in the file, without the rounding of the conversion.
        AxisKind::Rotary => {
            let degrees = (position.to_degrees() * 1e9).round() / 1e9;
            format!("{} = {degrees}°", axis.name())
        }
    });
    let positions: Vec<String> = positions.collect();
    format!(
        "run {} at {}",
        campaign.runs[run].name,
        positions.join(", ")
    )
}

/// The names of targets, as `P, Q, K`.
pub(crate) fn target_names(campaign: &Campaign, targets: &[usize]) -> String {
    let names = targets.iter().map(|&t| campaign.targets[t].name.as_str());
    names.collect::<Vec<_>>().join(", ")
}

/// A length as `line 7 (station S1, target P, run x at X = 20 mm)`.
pub(crate) fn length_in_words(campaign: &Campaign, lengths: &Lengths, reading: usize) -> String {
    let stop = stop_of(lengths, reading);
    let length = &lengths.readings[reading];
    format!(
        "line {} (station {}, target {}, {})",
        length.line,
        campaign.stations[stop.station].name,
        campaign.targets[length.target].name,
        step_in_words(campaign, stop.step),
    )
}

pub(crate) fn stop_of(lengths: &Lengths, reading: usize) -> &Stop {
    let stops = &lengths.stops;
    &stops[stops.partition_point(|stop| stop.readings.end <= reading)]
}

/// The error if only `found` targets that the axis under test moves, fewer than three, were measured at a step.
pub(crate) fn too_few_targets(campaign: &Campaign, step: usize, found: usize) -> Error {
    let axis = campaign.axis_under_test(step);
    let axis = axis.map_or("the axis", |axis| campaign.machine.axes()[axis].name());
    Error::not_identifiable(
        format!(
            "{}: {found} of the targets that {axis} moves were measured, three are needed to see its six \
             component errors",
            step_in_words(campaign, step),
        ),
        "measure the missing targets there, or leave out the rows of this step; where it moves more of them than the campaign says, \
         correct their `carried_by`",
    )
}
