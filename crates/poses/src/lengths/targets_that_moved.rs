//! Removed lengths that concentrate on a target: it stood elsewhere.

use std::collections::{BTreeMap, HashMap};

use trueaxis_kinematics::MICROMETRE;
use trueaxis_leastsquares::chi_squared_upper_tail;
use trueaxis_screening::{MOST_OF_A_PART, Removed, is_concentrated};

use crate::Error;
use crate::lengths::LengthsAdjustment;
use crate::lengths::refused::{AS_THEY_ARE, ASK_WHY};
use crate::report::StepMisfit;
use crate::words::step_in_words;

/// The coordinates of a displacement.
const COORDINATES: usize = 3;

/// The lengths of a part of the measurement, and those of them that were removed.
#[derive(Default)]
struct Part<'a> {
    lengths: usize,
    removed: Vec<&'a Removed>,
}

impl LengthsAdjustment<'_> {
    /// Refuses removals that concentrate on a target: it moved, and which half of its lengths is wrong
    /// nothing tells.
    pub(crate) fn check_targets(&self) -> Result<(), Error> {
        if self.screened.removed.is_empty() {
            return Ok(());
        }
        // Targets, then targets as seen from each station.
        let whole = self.parts(|_, target| (None, target));
        let from_stations =
            self.parts(|stop, target| (Some(self.lengths.stops[stop].station), target));
        let all_removed = self.screened.removed.len();
        for ((station, target), Part { lengths, removed }) in whole.iter().chain(&from_stations) {
            let count = removed.len();
            let is_most = count as f64 > MOST_OF_A_PART * *lengths as f64;
            if is_most || station.is_some() && is_concentrated(count, all_removed) {
                let from = station.map_or_else(String::new, |station| {
                    format!(" from station {}", self.campaign.stations[station].name)
                });
                let lines = removed
                    .iter()
                    .map(|r| self.lengths.readings[r.reading].line);
                return Err(Error::not_trustworthy(
                    format!(
                        "{count} of the {lengths} lengths to target {}{from} contradict the others (lines \
                         {} to {}): it moved, or a tripod did",
                        self.campaign.targets[*target].name,
                        lines.clone().min().unwrap_or_default(),
                        lines.max().unwrap_or_default(),
                    ),
                    format!(
                        "check that both sat firmly, and measure again; {ASK_WHY}; {AS_THEY_ARE}"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Steps at which the lengths to a target contradict the rigid body so much that half of them or more
    /// were removed. The sum of squares is that of the displacement of the target, whose three coordinates
    /// explain them.
    pub(crate) fn lost_targets(&self) -> Vec<StepMisfit> {
        if self.screened.removed.is_empty() {
            return Vec::new();
        }
        let parts = self.parts(|stop, target| (self.lengths.stops[stop].step, target));
        let lost = |((step, _), Part { lengths, removed }): ((usize, usize), Part<'_>)| {
            if removed.len() < COORDINATES || 2 * removed.len() < lengths {
                return None;
            }
            let squares: f64 = removed.iter().map(|r| r.error_mm * r.error_mm).sum();
            let in_u = removed.iter().map(|r| (r.error_mm / r.u_mm).powi(2));
            let chi_squared = in_u.sum();
            Some(StepMisfit {
                step: step_in_words(self.campaign, step),
                rms_um: (squares / removed.len() as f64).sqrt() / MICROMETRE,
                chi_squared,
                degrees_of_freedom: COORDINATES,
                p_value: chi_squared_upper_tail(chi_squared, COORDINATES as f64),
            })
        };
        parts.into_iter().filter_map(lost).collect()
    }

    /// The lengths by what `key` makes of stop and target.
    fn parts<K: Ord>(&self, key: impl Fn(usize, usize) -> K) -> BTreeMap<K, Part<'_>> {
        let removed = self.screened.removed.iter();
        let removed: HashMap<usize, &Removed> = removed.map(|r| (r.reading, r)).collect();
        let mut parts: BTreeMap<K, Part<'_>> = BTreeMap::new();
        for (number, stop) in self.lengths.stops.iter().enumerate() {
            for i in stop.readings.clone() {
                let part = parts
                    .entry(key(number, self.lengths.readings[i].target))
                    .or_default();
                part.lengths += 1;
                part.removed.extend(removed.get(&i));
            }
        }
        parts
    }
}
