//! The misfit by groups of readings.

use std::collections::BTreeMap;

use crate::Place;

/// Whitened residuals before and after, for the misfit of groups of readings.
pub(crate) struct Misfits<'m> {
    pub(crate) residuals: [&'m [f64]; 2],
    /// The degrees of freedom, of which rows have equal shares.
    pub(crate) degrees_of_freedom: [f64; 2],
    /// Number of readings, and of rows of each.
    pub(crate) readings: usize,
    pub(crate) rows: usize,
    /// Standard deviation of a row, µm.
    pub(crate) noise_um: f64,
}

impl Misfits<'_> {
    /// The groups of readings with something in common, in the order of their keys, each with its name. A single group
    /// says nothing about where the misfit is.
    pub(crate) fn places(
        &self,
        by: &'static str,
        groups: impl IntoIterator<Item = Option<(usize, String)>>,
    ) -> Vec<Place> {
        let mut readings_of: BTreeMap<usize, (String, Vec<usize>)> = BTreeMap::new();
        for (reading, group) in groups.into_iter().enumerate() {
            if let Some((key, name)) = group {
                let of_key = readings_of.entry(key).or_insert((name, Vec::new()));
                of_key.1.push(reading);
            }
        }
        if readings_of.len() < 2 {
            return Vec::new();
        }
        let place = |(name, readings): (String, Vec<usize>)| Place {
            by,
            name,
            readings: readings.len(),
            before_um: self.rms_um(&readings, 0),
            after_um: self.rms_um(&readings, 1),
        };
        readings_of.into_values().map(place).collect()
    }

    fn rms_um(&self, readings: &[usize], k: usize) -> f64 {
        let of_reading = |&i: &usize| &self.residuals[k][self.rows * i..self.rows * (i + 1)];
        let squares: f64 = readings.iter().flat_map(of_reading).map(|e| e * e).sum();
        let share = self.degrees_of_freedom[k] / self.readings as f64;
        self.noise_um * (squares / (readings.len() as f64 * share)).sqrt()
    }
}

/// The key and the name of a side of approach.
pub(crate) fn side(sign: f64) -> (usize, String) {
    match sign < 0.0 {
        false => (0, "+1".to_owned()),
        true => (1, "-1".to_owned()),
    }
}
