//! Tables that read again what an earlier one did: without a calibration each has a mean curve of its own, and
//! differences between them are visible only as cycles of one table.

use trueaxis_campaign::Verification;

use crate::verification::arrivals::is_same;

/// A notice where `verification` reads most of the positions of one `before`, of the same points of the machine.
pub(crate) fn read_again(verification: &Verification, before: &[Verification]) -> Option<String> {
    let are_same = |one: &[f64], other: &[f64]| one.iter().zip(other).all(|(a, b)| is_same(*a, *b));
    let is_again = |earlier: &&Verification| {
        let is_there = |at: &[f64]| earlier.readings.iter().any(|r| are_same(&r.positions, at));
        let again = verification
            .readings
            .iter()
            .filter(|r| is_there(&r.positions));
        earlier.kind == verification.kind && 2 * again.count() > verification.readings.len()
    };
    let earlier = before.iter().find(is_again)?;
    Some(format!(
        "{}: it reads the positions of {} again; without a calibration each table has a mean curve of its own, and how they differ is not \
         judged: if nothing was changed in between, give them as cycles of one table",
        verification.name, earlier.name
    ))
}
