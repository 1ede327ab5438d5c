//! The end of the search: the final adjustment of the remaining readings, and the list of removed ones.

use std::sync::Arc;

use trueaxis_multilateration::{Interruption, Network, solve, solve_from};

use super::Search;
use crate::estimate_noise::estimate_noise;
use crate::robust_weights::REMOVED;
use crate::screened::{Removed, Screened};
use crate::{Error, guard};

impl Search {
    /// The removed readings with their errors.
    pub(crate) fn removed(&mut self) -> Result<Vec<Removed>, Error> {
        let (tests, _) = self.tests()?;
        let factors = self.inflation.iter().enumerate();
        let removed = factors.filter(|&(_, &factor)| factor >= REMOVED);
        Ok(removed
            .map(|(reading, _)| Removed {
                reading,
                error_mm: tests.readings[reading].error_mm,
                u_mm: tests.readings[reading].sigma_mm,
                unchecked: self.unchecked[reading],
            })
            .collect())
    }

    /// The final adjustment of the remaining part of the original network. The search gives up its own solution: both
    /// together would be most of the memory that a large network takes.
    pub(crate) fn finished(&mut self, original: &Network) -> Result<Screened, Error> {
        self.merge_empty_occupations()?;
        let wandering = self.wandering_zeros()?;
        let removed = self.removed()?;
        guard::check(&self.network, &removed, self.most_removed)?;
        let without: Vec<usize> = removed.iter().map(|r| r.reading).collect();
        let (mut network, kept) = original.without(&without);
        network.interruptions = self
            .network
            .interruptions
            .iter()
            .map(|i| Interruption {
                first_reading: kept.partition_point(|&reading| reading < i.first_reading),
                ..*i
            })
            .collect();
        let whole = self.is_whole(&network);
        let mut solution = match self.solution.take().map(Arc::unwrap_or_clone) {
            Some(solved) if whole && solved.termination.is_converged() => solved,
            Some(near) => solve_from(&network, &near)?,
            None => solve(&network)?,
        };
        let given_squares = solution.squares;
        let noise = estimate_noise(&mut network, &mut solution, self.declared)?;
        Ok(Screened {
            given_squares,
            jumps: self.found_jumps(&network, &solution),
            wandering,
            converged: self.converged,
            tests: None,
            network,
            solution: Arc::new(solution),
            noise,
            kept,
            removed,
        })
    }
}
