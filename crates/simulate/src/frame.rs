//! Which errors the reference frame takes, so that a scenario cannot contain them.
//!
//! True errors that would move the frame of `trueaxis-kinematics` against the simulated machine's own
//! are refused: the truth is expressed in the machine's frame.

use trueaxis_kinematics::{FrameRule, LocationComponent, Machine};

/// Why that location error of that axis is zero by definition, if it is.
pub(crate) fn why_zero(
    frame: &FrameRule,
    machine: &Machine,
    axis: usize,
    component: LocationComponent,
) -> Option<String> {
    if !frame.defines(machine, axis, component) {
        return None;
    }
    let name = |axis: usize| machine.axes()[axis].name();
    let lines: Vec<usize> = frame.lines().collect();
    Some(match lines.as_slice() {
        [] => "without a linear run the reference frame has its origin at the targets' home \
               positions, so a shift along an axis of rotation shifts the frame"
            .to_owned(),
        [first, ..] if *first == axis => format!(
            "the reference frame takes its first direction from the average line of {}",
            name(axis)
        ),
        [first, second] if *second == axis => format!(
            "the average lines of {} and {} lie in a plane of the reference frame, so {} can only \
             tilt about the normal of that plane",
            name(*first),
            name(axis),
            name(axis)
        ),
        _ => format!(
            "the reference frame has its origin at the home positions of the targets that {} moves, \
             so a shift along this axis of rotation shifts the frame",
            name(axis)
        ),
    })
}
