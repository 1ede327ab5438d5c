//! Periods shorter than two steps, which positions show as longer ones.
//!
//! At equal steps Δ a wave of period P is, reading by reading, one of `1/|k/Δ ± 1/P|` for every whole k. At unequal steps
//! it is nearly so for k = 1.

use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::sampling;

/// Steps of less than this part of the usual one tell them apart.
const CLOSER: f64 = 0.3;

/// A notice about a period that was found in a line, in the unit of positions.
pub(crate) fn doubt(comparison: &Comparison<'_>, period: f64) -> Option<String> {
    let axis = comparison.line()?;
    let [_, step] = sampling(comparison, axis)?;
    let positions = comparison.positions(axis);
    let shortest = positions.windows(2).map(|two| two[1] - two[0]);
    if shortest.fold(f64::INFINITY, f64::min) < CLOSER * step {
        return None;
    }
    let kind = comparison.machine.axes()[axis].kind();
    let [first, second, third] = [(1.0, -1.0), (1.0, 1.0), (2.0, -1.0)].map(|(k, sign)| {
        let shorter = (k / step + sign / period).recip();
        format!("{:.3}", kind.position_in_file(shorter))
    });
    let unit = kind.position_unit();
    Some(format!(
        "at positions {:.3} {unit} apart a wave of {:.3} {unit} looks like one of {first}, {second}, {third} {unit} or a shorter one: before it is \
         compared with the pitch of a screw, read some positions much closer together",
        kind.position_in_file(step),
        kind.position_in_file(period),
    ))
}
