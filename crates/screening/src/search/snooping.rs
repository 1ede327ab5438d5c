//! Data snooping: which readings are removed, and which come back.

use trueaxis_multilateration::Tests;

use super::{HOPELESS, MAX_ROUNDS, READINGS_LEVEL, Search};
use crate::Error;
use crate::robust_weights::REMOVED;

/// A reading that left again after so many returns stays out: alone it may seem to fit where its visit does not.
const MOST_RETURNS: u8 = 2;

impl Search {
    pub(super) fn snoop(&mut self) -> Result<(), Error> {
        self.returns.fill(0);
        for _ in 0..MAX_ROUNDS {
            if self.is_lost() {
                break;
            }
            self.too_many(HOPELESS * self.most_removed)?;
            let (tests, spread) = self.tests()?;
            if let Some(jump) = self.jump(&tests.readings, spread) {
                self.split(jump.station, jump.first_reading);
                self.solve()?;
                continue;
            }
            let changes = self.changes(&tests, spread);
            if changes.is_empty() {
                return Ok(());
            }
            for (reading, factor) in changes {
                self.returns[reading] += u8::from(factor < REMOVED);
                self.inflation[reading] = factor;
            }
            self.solve()?;
        }
        self.converged = false;
        Ok(())
    }

    /// For each group the reading to be removed first, or else the visit to be removed as a whole, or else the reading
    /// that should come back first; each with its new variance factor.
    pub(super) fn changes(&self, tests: &Tests, spread: f64) -> Vec<(usize, f64)> {
        let limit = self.limit(READINGS_LEVEL) * spread;
        let groups = self.network.groups.len();
        let mut worst: Vec<Option<(f64, usize)>> = vec![None; groups];
        let mut best: Vec<Option<(f64, usize)>> = vec![None; groups];
        for visit in &self.network.visits {
            for i in visit.readings.clone().filter(|&i| !self.unchecked[i]) {
                let w = tests.readings[i].w.abs();
                let is_out = self.inflation[i] >= REMOVED;
                if is_out && w <= limit && self.returns[i] < MOST_RETURNS {
                    take_if_larger(&mut best[visit.group], -w, i);
                } else if !is_out && w > limit {
                    take_if_larger(&mut worst[visit.group], w, i);
                }
            }
        }
        let visits = self.worst_visits(&tests.visits, limit);
        let mut changes = Vec::new();
        for ((worst, visit), best) in worst.into_iter().zip(visits).zip(best) {
            match (worst, visit, best) {
                (Some((_, i)), _, _) => changes.push((i, REMOVED)),
                (None, Some(visit), _) => {
                    let readings = self.network.visits[visit].readings.clone();
                    changes.extend(readings.map(|i| (i, REMOVED)));
                }
                (None, None, Some((_, i))) => changes.push((i, 1.0)),
                (None, None, None) => {}
            }
        }
        changes
    }

    /// For each group the visit whose lengths are off together, if any: single lengths do not show it, because they
    /// allow for the machine's repeatability.
    fn worst_visits(&self, tests: &[f64], limit: f64) -> Vec<Option<usize>> {
        let mut worst: Vec<Option<(f64, usize)>> = vec![None; self.network.groups.len()];
        let tests = tests.iter().map(|w| w.abs());
        for ((visit, content), w) in self.network.visits.iter().enumerate().zip(tests) {
            let mut readings = content.readings.clone();
            let all = readings.all(|i| self.inflation[i] < REMOVED);
            if all && w > limit {
                take_if_larger(&mut worst[content.group], w, visit);
            }
        }
        let visits = worst.into_iter().map(|worst| worst.map(|(_, visit)| visit));
        visits.collect()
    }
}

/// Replaces a smaller number and its index.
fn take_if_larger(largest: &mut Option<(f64, usize)>, size: f64, of: usize) {
    if largest.is_none_or(|(most, _)| size > most) {
        *largest = Some((size, of));
    }
}
