//! The misfit by groups of readings.

use std::collections::BTreeMap;

use crate::Place;

/// The groups of rows with something in common, in the order of their keys, each with its name; `rms_um` is the rms
/// of the rows of a group, before and after. A single group says nothing about where the misfit is.
pub(crate) fn places(
    by: &'static str,
    groups: impl IntoIterator<Item = Option<(usize, String)>>,
    rms_um: &dyn Fn(&[usize]) -> [f64; 2],
) -> Vec<Place> {
    let mut rows_of: BTreeMap<usize, (String, Vec<usize>)> = BTreeMap::new();
    for (row, group) in groups.into_iter().enumerate() {
        if let Some((key, name)) = group {
            let of_key = rows_of.entry(key).or_insert((name, Vec::new()));
            of_key.1.push(row);
        }
    }
    if rows_of.len() < 2 {
        return Vec::new();
    }
    let place = |(name, rows): (String, Vec<usize>)| {
        let [before_um, after_um] = rms_um(&rows);
        Place {
            by,
            name,
            readings: rows.len(),
            before_um,
            after_um,
        }
    };
    rows_of.into_values().map(place).collect()
}

/// The key and the name of a side of approach.
pub(crate) fn side(sign: f64) -> (usize, String) {
    match sign < 0.0 {
        false => (0, "+1".to_owned()),
        true => (1, "-1".to_owned()),
    }
}
