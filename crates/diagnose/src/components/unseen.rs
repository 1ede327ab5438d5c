//! Periods that equal steps cannot show: those that fit into a step a whole number of times look constant at every
//! step, and a constant belongs to the value at home.

use trueaxis_calibrate::AxisResult;
use trueaxis_files::round;
use trueaxis_kinematics::Component;
use trueaxis_predict::Unit;

use crate::diagnosis::NotObservable;

/// Largest difference of steps that count as equal, in steps: a period then shifts by less than 1/1000 of itself from
/// one to the next.
const EQUAL_TOL: f64 = 1e-3;

/// Number of periods listed.
const LISTED: u32 = 4;

/// The periods that the positions of an axis hide; `None` if they are not equally spaced.
pub(crate) fn periods_of_the_step(axis: &AxisResult) -> Option<NotObservable> {
    let step = equal_step(axis)?;
    let (size, unit) = (axis.kind.position_in_file(step), axis.kind.position_unit());
    let periods: Vec<String> = (1..=LISTED)
        .map(|n| format!("{}", round(size / f64::from(n), 3)))
        .collect();
    let name = &axis.name;
    let amount = |component: &Component| {
        let unit = Unit::of_component(*component).suffix();
        let text =
            format!("up to 2 {unit} between the steps per {unit} of amplitude, 0 at the steps");
        (component.name(name), text)
    };
    Some(NotObservable {
        effect: "cyclic_error",
        subject: format!("axis {name}"),
        reason: format!(
            "the step is {} {unit}: an error with the period {} {unit} and so on is the same at every step and cannot be told from none; a period below {} {unit} shows as a longer one",
            round(size, 3),
            periods.join(", "),
            round(2.0 * size, 3)
        ),
        bias_per_unit: Component::ALL.iter().map(amount).collect(),
        measure: format!(
            "one step of {name} again in at least eight equal parts, or the whole line with a step that no pitch is a multiple of"
        ),
    })
}

/// The common distance of all neighbouring positions, mm or rad.
fn equal_step(axis: &AxisResult) -> Option<f64> {
    let mut positions: Vec<f64> = axis.nodes.iter().map(|node| node.position).collect();
    positions.sort_by(f64::total_cmp);
    let mut gaps: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let largest = gaps.iter().copied().fold(0.0, f64::max);
    // Both sides of approach have the same positions.
    gaps.retain(|gap| *gap > EQUAL_TOL * largest);
    let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    (largest > 0.0 && largest - smallest <= EQUAL_TOL * largest).then_some(largest)
}
