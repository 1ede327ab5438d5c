//! The order of measuring.

use trueaxis_campaign::Verification;

use crate::verification::arrivals::are_timed;

/// The readings in the order of their clock, where the table has one: its rows may stand in any.
pub(crate) fn in_order_of_measuring(verification: &Verification) -> Verification {
    let mut ordered = verification.clone();
    if are_timed(&ordered.readings) {
        ordered.readings.sort_by(|a, b| {
            let time_s = |reading: Option<f64>| reading.unwrap_or_default();
            time_s(a.time_s).total_cmp(&time_s(b.time_s))
        });
    }
    ordered
}
