//! Splits of occupations where the zero of a station jumped: found, placed, and undone.

use trueaxis_multilateration::{Interruption, Network, ReadingTest, Solution, Whitened};

use super::Search;
use crate::Error;
use crate::interruption::Rivals;
use crate::jump_tests::{JumpTest, largest_jumps};
use crate::robust_weights::{REMOVED, distances_from_neighbours};
use crate::screened::{Jump, WanderingZero};

/// Probability that any occupation of a network without interruptions is split.
pub(super) const STEPS_LEVEL: f64 = 1e-3;

/// A jump with fewer readings before or after it cannot be distinguished from gross errors.
const LEAST_JUMP: usize = 4;

/// Width of the weights, in spreads, after a split: most far readings are removed by then.
const WIDE_AGAIN: f64 = 4.0;

/// Splits for each station on average; more of them are not interruptions.
const MOST_SPLITS: usize = 3;

impl Search {
    pub(super) fn find_interruptions(&mut self) -> Result<(), Error> {
        let mut widest = f64::INFINITY;
        loop {
            let zeros = self.network.zero_of_readings();
            self.let_go(widest, |tests| distances_from_neighbours(tests, &zeros))?;
            let (tests, spread) = self.tests()?;
            let Some(jump) = self.jump(&tests.readings, spread) else {
                return Ok(());
            };
            if self.network.interruptions.len() == MOST_SPLITS * self.network.stations.len() {
                self.network.interruptions.clear();
                self.never_split = true;
                return self.solve();
            }
            self.split(jump.station, jump.first_reading);
            self.solve()?;
            widest = WIDE_AGAIN;
        }
    }

    /// The most significant jump that is an interruption, if any; a jump less significant than a single reading may
    /// be caused by that reading.
    pub(super) fn jump(&mut self, tests: &[ReadingTest], spread: f64) -> Option<JumpTest> {
        if self.never_split {
            return None;
        }
        let (jumps, rows) = self.significant_jumps(tests, spread)?;
        let solution = self.solution.as_deref()?;
        jumps.into_iter().find(|jump| {
            Rivals::of(jump, (&self.network, solution), &rows, spread)
                .is_interruption(self.splits_what_wanders)
        })
    }

    /// The stations whose zeros wander: a jump would be significant, but is not needed beside the wandering.
    pub(super) fn wandering_zeros(&mut self) -> Result<Vec<WanderingZero>, Error> {
        let (tests, spread) = self.tests()?;
        if self.never_split || self.splits_what_wanders {
            return Ok(Vec::new());
        }
        let significant = self.significant_jumps(&tests.readings, spread);
        let (Some((jumps, rows)), Some(solution)) = (significant, self.solution.as_deref()) else {
            return Ok(Vec::new());
        };
        let wandering = jumps.into_iter().filter_map(|jump| {
            let rivals = Rivals::of(&jump, (&self.network, solution), &rows, spread);
            let rms_mm = rivals.wandering_mm()?;
            Some(WanderingZero {
                station: jump.station,
                rms_mm,
            })
        });
        Ok(wandering.collect())
    }

    /// For each zero its largest jump, if it is significant, the most significant one first, with the rows of the hat
    /// matrix; `None` if there is none.
    fn significant_jumps(
        &mut self,
        tests: &[ReadingTest],
        spread: f64,
    ) -> Option<(Vec<JumpTest>, Whitened)> {
        let mut rows = None;
        if self.largest_jumps.is_none() {
            let new = self.hat_rows()?;
            self.largest_jumps = Some(largest_jumps(&self.network, &new));
            rows = Some(new);
        }
        let mut jumps = self.largest_jumps.clone()?;
        let taking_part = tests.iter().zip(&self.inflation);
        let largest_reading = taking_part
            .filter(|&(_, &factor)| factor <= 1.0)
            .fold(0.0_f64, |largest, (test, _)| largest.max(test.w.abs()));
        let limit = (self.limit(STEPS_LEVEL) * spread).max(largest_reading);
        jumps.retain(|jump| jump.w.abs() > limit && jump.before.min(jump.after) >= LEAST_JUMP);
        jumps.sort_by(|a, b| b.w.abs().total_cmp(&a.w.abs()));
        if jumps.is_empty() {
            return None;
        }
        Some((jumps, rows.or_else(|| self.hat_rows())?))
    }

    pub(super) fn split(&mut self, station: usize, first_reading: usize) {
        let new = Interruption {
            station,
            first_reading,
        };
        if self.network.interruptions.contains(&new) {
            return;
        }
        self.network.interruptions.push(new);
        let order = |i: &Interruption| (i.first_reading, i.station);
        self.network.interruptions.sort_by_key(order);
    }

    /// Seeks the instant of each interruption again, with all good readings at full weight.
    pub(super) fn place_interruptions(&mut self) -> Result<(), Error> {
        self.excluded.clear();
        let (_, spread) = self.tests()?;
        for interruption in self.network.interruptions.clone() {
            self.network.interruptions.retain(|i| *i != interruption);
            self.solve()?;
            let (Some(rows), Some(solution)) = (self.hat_rows(), self.solution.as_deref()) else {
                self.split(interruption.station, interruption.first_reading);
                self.solve()?;
                continue;
            };
            let jumps = largest_jumps(&self.network, &rows).into_iter();
            let of_station = jumps.filter(|s| s.station == interruption.station);
            let best = of_station.max_by(|a, b| a.w.abs().total_cmp(&b.w.abs()));
            let first_reading = best.map_or(interruption.first_reading, |s| s.first_reading);
            let excluded = best
                .map(|jump| Rivals::of(&jump, (&self.network, solution), &rows, spread).excluded());
            self.split(interruption.station, first_reading);
            let placed = Interruption {
                first_reading,
                ..interruption
            };
            self.excluded
                .extend(excluded.map(|excluded| (placed, excluded)));
            self.solve()?;
        }
        Ok(())
    }

    /// The split with the least significant jump, if that is not significant.
    pub(super) fn weakest_split(&self, spread: f64) -> Option<usize> {
        let solution = self.solution.as_ref()?;
        let all = jumps(&self.network, solution).into_iter().enumerate();
        let sizes = all.map(|(split, jump)| (split, jump.change_mm.abs() / jump.u_mm));
        let weakest = sizes.min_by(|a, b| a.1.total_cmp(&b.1));
        let (split, size) = weakest?;
        (size <= self.limit(STEPS_LEVEL) * spread).then_some(split)
    }

    /// Undoes splits that separate nothing because all readings on one side were removed.
    pub(super) fn merge_empty_occupations(&mut self) -> Result<(), Error> {
        loop {
            let mut is_used = vec![false; self.network.zeros()];
            let factors = &self.inflation;
            for (zero, &factor) in self.network.zero_of_readings().into_iter().zip(factors) {
                is_used[zero] |= factor < REMOVED;
            }
            let stations = self.network.stations.len();
            let empty = self
                .network
                .interruptions
                .iter()
                .enumerate()
                .position(|(k, i)| !is_used[stations + k] || !is_used[i.station]);
            let Some(k) = empty else {
                return Ok(());
            };
            self.network.interruptions.remove(k);
            self.solve()?;
        }
    }

    /// The jumps of the clean network at the readings of the original one.
    pub(super) fn found_jumps(&self, clean: &Network, solution: &Solution) -> Vec<Jump> {
        let found = jumps(clean, solution).into_iter();
        let original = &self.network.interruptions;
        found
            .zip(original)
            .map(|(jump, interruption)| {
                let mut told = self.excluded.iter();
                let told = told.find(|(own, _)| own == interruption);
                let excluded = told.map(|(_, excluded)| *excluded).unwrap_or_default();
                Jump {
                    first_reading: interruption.first_reading,
                    tripod_may_have_moved: !excluded.tripod,
                    may_wander: self.splits_what_wanders || !excluded.wander,
                    ..jump
                }
            })
            .collect()
    }
}

/// The jumps at the interruptions of a solved network.
fn jumps(network: &Network, solution: &Solution) -> Vec<Jump> {
    let stations = network.stations.len();
    let mut last: Vec<usize> = (0..stations).collect();
    let interruptions = network.interruptions.iter().enumerate();
    interruptions
        .map(|(k, interruption)| {
            let (before, after) = (last[interruption.station], stations + k);
            last[interruption.station] = after;
            // A smaller dead path makes lengths longer.
            let (change_mm, u_mm) = solution.difference_of_dead_paths(before, after);
            Jump {
                station: interruption.station,
                first_reading: interruption.first_reading,
                change_mm,
                u_mm,
                tripod_may_have_moved: true,
                may_wander: false,
            }
        })
        .collect()
}
