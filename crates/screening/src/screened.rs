//! The result of screening a network, and what was removed.

use std::sync::Arc;

use trueaxis_multilateration::{Network, Noise, Solution, Tests, solve};

use crate::Error;
use crate::estimate_noise::{NoiseEstimate, estimate_noise};
use crate::uneven::{LessWeight, weigh_uneven};

/// A network that was cleaned and solved.
#[derive(Debug, Clone)]
pub struct Screened {
    /// The lengths that were kept, with the interruptions found and the estimated noise.
    pub network: Network,
    /// Its solution; the search may still share it.
    pub solution: Arc<Solution>,
    /// The estimated noise.
    pub noise: NoiseEstimate,
    /// Sum of squares of the whitened residuals with the given noise: chi-squared with the degrees of freedom of the
    /// solution if that noise is right.
    pub given_squares: f64,
    /// For each reading of the network the reading of the original one.
    pub kept: Vec<usize>,
    /// The readings that were removed, in measuring order.
    pub removed: Vec<Removed>,
    /// The jumps found in the zeros of stations, in measuring order.
    pub jumps: Vec<Jump>,
    /// The zeros that wander in a smooth course instead of jumping.
    pub wandering: Vec<WanderingZero>,
    /// Whether the search came to an end. If not, tests still ask for changes.
    pub converged: bool,
    /// The tests at the solution, if the search made them ([`Screened::tests`]).
    pub tests: Option<Arc<Tests>>,
}

/// A reading that contradicts the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removed {
    /// The reading in the original network.
    pub reading: usize,
    /// Its estimated error, observed minus true, mm.
    pub error_mm: f64,
    /// Standard uncertainty of the error, mm.
    pub u_mm: f64,
    /// The reading itself does not contradict the others, but nothing checks it since a reading of the same point was
    /// removed.
    pub unchecked: bool,
}

/// A jump of a station's zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// The station.
    pub station: usize,
    /// First reading after the jump, in the original network.
    pub first_reading: usize,
    /// By how much the lengths changed, mm.
    pub change_mm: f64,
    /// Standard uncertainty of the change, mm.
    pub u_mm: f64,
    /// A displacement of the station explains the jump as well.
    pub tripod_may_have_moved: bool,
    /// A zero or a tripod that wanders explains the jump nearly as well.
    pub may_wander: bool,
}

/// A station's zero that wanders smoothly. A swaying tripod changes the lengths in nearly the same way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WanderingZero {
    /// The station.
    pub station: usize,
    /// Rms of its course over the occupation, mm.
    pub rms_mm: f64,
}

impl Screened {
    /// One adjustment of all readings with full weight, and the noise that they show.
    pub fn plain(network: &Network, declared: bool) -> Result<Self, Error> {
        let kept = (0..network.readings.len()).collect();
        Self::adjusted(network.clone(), kept, declared)
    }

    /// The same readings in other groups: those that `found` kept, with occupations split as there. Nothing is sought
    /// again; the noise is estimated from this network.
    pub fn as_found(network: &Network, declared: bool, found: &Self) -> Result<Self, Error> {
        let without: Vec<usize> = found.removed.iter().map(|r| r.reading).collect();
        let (mut network, kept) = network.without(&without);
        network
            .interruptions
            .clone_from(&found.network.interruptions);
        Ok(found.found_in(Self::adjusted(network, kept, declared)?))
    }

    /// The same with less weight for lengths that scatter more than the others, and which they are; `None` if there are
    /// none. The noise is estimated again; `given` is that of the campaign.
    pub fn weighed(
        &self,
        given: Noise,
        declared: bool,
    ) -> Result<Option<(Self, Vec<LessWeight>)>, Error> {
        if self.solution.is_of_computed_lengths() {
            return Ok(None);
        }
        let tests = self.tests();
        let Some(weighed) = weigh_uneven(&self.network, (&self.solution, &tests), declared)? else {
            return Ok(None);
        };
        let network = Network {
            noise: given,
            ..weighed.network
        };
        let found = self.found_in(Self::adjusted(network, self.kept.clone(), declared)?);
        Ok(Some((found, weighed.uneven)))
    }

    /// What was found here in another adjustment of the same readings.
    fn found_in(&self, adjusted: Self) -> Self {
        Self {
            removed: self.removed.clone(),
            jumps: self.jumps.clone(),
            wandering: self.wandering.clone(),
            converged: self.converged,
            ..adjusted
        }
    }

    fn adjusted(mut network: Network, kept: Vec<usize>, declared: bool) -> Result<Self, Error> {
        let mut solution = solve(&network)?;
        let given_squares = solution.squares;
        let noise = estimate_noise(&mut network, &mut solution, declared)?;
        Ok(Self {
            kept,
            network,
            solution: Arc::new(solution),
            noise,
            given_squares,
            removed: Vec::new(),
            jumps: Vec::new(),
            wandering: Vec::new(),
            converged: true,
            tests: None,
        })
    }

    /// Readings removed, and occupations split.
    pub fn changes(&self) -> usize {
        self.removed.len() + self.jumps.len()
    }

    /// The tests of every reading and visit of the network.
    pub fn tests(&self) -> Arc<Tests> {
        let made = self.tests.clone();
        made.unwrap_or_else(|| Arc::new(self.solution.tests(&self.network)))
    }

    /// Observed minus computed length of every reading of the original network, mm.
    pub fn residuals_mm(&self) -> Vec<f64> {
        let mut residuals_mm = vec![0.0; self.kept.len() + self.removed.len()];
        for (&reading, &residual_mm) in self.kept.iter().zip(&self.solution.residuals_mm) {
            residuals_mm[reading] = residual_mm;
        }
        for removed in &self.removed {
            residuals_mm[removed.reading] = removed.error_mm;
        }
        residuals_mm
    }
}
