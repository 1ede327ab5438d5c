//! What the digits of the readings cannot show.
//!
//! A reading that is written in steps of δ is uncertain by `δ/√12` of them alone (JCGM 100:2008, F.2.2.1). Where a control
//! repeats to its last digit, nothing else is left of the noise.

use crate::verification::comparison::Comparison;

/// Readings that differ by less than this part of them are equal.
const EQUAL: f64 = 1e-9;

/// Standard uncertainty of a reading from its last digit, µm: the smallest difference of any two readings stands for that
/// digit. `None` if all readings are equal.
pub(crate) fn resolution_um(comparison: &Comparison<'_>) -> Option<f64> {
    let mut values: Vec<f64> = comparison.arrivals.iter().map(|a| a.value_um).collect();
    values.sort_by(f64::total_cmp);
    let gaps = values.windows(2).filter_map(|pair| {
        let (gap, larger) = (pair[1] - pair[0], pair[0].abs().max(pair[1].abs()));
        (gap > EQUAL * larger).then_some(gap)
    });
    let least = gaps.min_by(f64::total_cmp);
    least.map(|gap| gap / 12_f64.sqrt())
}
