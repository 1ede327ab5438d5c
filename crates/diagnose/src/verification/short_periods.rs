//! Periods shorter than two steps, which positions show as longer ones.
//!
//! At equal steps Δ a wave of period P is, reading by reading, one of `1/|k/Δ ± 1/P|` for every whole k.

use std::f64::consts::TAU;

use crate::verification::comparison::Comparison;
use crate::verification::hypotheses::sampling;

/// Mean of `exp(2πi q/Δ)` over the positions, above which these are at equal steps.
const EQUAL: f64 = 0.95;

/// A notice about a period that was found in a line, in the unit of positions.
pub(crate) fn doubt(comparison: &Comparison<'_>, period: f64) -> Option<String> {
    let axis = comparison.line()?;
    let [_, step] = sampling(comparison, axis)?;
    let positions = comparison.positions(axis);
    let waves = positions.iter().map(|q| (TAU * q / step).sin_cos());
    let [sine, cosine] = waves.fold([0.0; 2], |[s, c], wave| [s + wave.0, c + wave.1]);
    if sine.hypot(cosine) < EQUAL * positions.len() as f64 {
        return None;
    }
    let kind = comparison.machine.axes()[axis].kind();
    let [first, second, third] = [(1.0, 1.0), (2.0, -1.0), (2.0, 1.0)].map(|(k, sign)| {
        let shorter = (k / step + sign / period).recip();
        format!("{:.3}", kind.position_in_file(shorter))
    });
    let unit = kind.position_unit();
    Some(format!(
        "at positions {:.3} {unit} apart a wave of {:.3} {unit} looks like one of {first}, {second}, {third} {unit} and others: before it is \
         compared with the pitch of a screw, read some positions much closer together",
        kind.position_in_file(step),
        kind.position_in_file(period),
    ))
}
