//! Positions read from encoders instead of the commanded ones.

use trueaxis_campaign::{Verification, VerificationKind};

/// Part of the widest step between neighbouring positions below which no step was commanded.
const NO_STEP: f64 = 0.05;

/// What to do where positions are read out.
pub const GIVE_COMMANDED: &str = "most positions are nearly alike, but not the same: give those commanded, not what encoders show";

/// Whether most positions of a line of positioning differ by next to nothing from others.
pub fn positions_are_read_out(verification: &Verification) -> bool {
    let VerificationKind::Positioning { axis, .. } = verification.kind else {
        return false;
    };
    let positions = verification.readings.iter().map(|r| r.positions[axis]);
    let mut positions: Vec<f64> = positions.collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup();
    are_read_out(&positions)
}

/// The same of the different positions of an axis, ascending.
pub fn are_read_out(positions: &[f64]) -> bool {
    let steps = || positions.windows(2).map(|two| two[1] - two[0]);
    let widest = steps().fold(0.0, f64::max);
    2 * steps().filter(|step| *step < NO_STEP * widest).count() > positions.len()
}
