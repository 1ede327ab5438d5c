//! What screening leaves of a network, and what it took away.

use std::sync::Arc;

use trueaxis_multilateration::{Network, Solution, Tests, solve};

use crate::Error;
use crate::estimate_noise::{NoiseEstimate, estimate_noise};

/// A network that was cleaned and solved.
#[derive(Debug, Clone)]
pub struct Screened {
    /// The lengths that were kept, with the interruptions found and the estimated noise.
    pub network: Network,
    /// Its solution; the search shares it while it lasts.
    pub solution: Arc<Solution>,
    /// The estimated noise.
    pub noise: NoiseEstimate,
    /// Sum of squares of the whitened residuals with the given noise: chi-squared with the degrees of
    /// freedom of the solution if that is right.
    pub given_squares: f64,
    /// For each reading of the network the reading of the original one.
    pub kept: Vec<usize>,
    /// The readings that were removed, in measuring order.
    pub removed: Vec<Removed>,
    /// The jumps found in the zeros of stations, in measuring order.
    pub jumps: Vec<Jump>,
    /// The zeros that wander in a course that is no jump.
    pub wandering: Vec<WanderingZero>,
    /// Whether the search came to an end. If not, tests still ask for changes.
    pub settled: bool,
    /// The tests at the solution, where the search has made them ([`Screened::tests`]).
    pub tests: Option<Arc<Tests>>,
}

/// A reading that contradicts the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Removed {
    /// The reading in the original network.
    pub reading: usize,
    /// Its estimated error, observed minus right, mm.
    pub error_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_mm: f64,
    /// It does not contradict the others, but nothing checks it beside a reading of the same point that
    /// does.
    pub unchecked: bool,
}

/// A jump of a station's zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// The station.
    pub station: usize,
    /// First reading after it, in the original network.
    pub first_reading: usize,
    /// By how much the lengths changed, mm.
    pub change_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_mm: f64,
    /// A displacement of the station explains it as well as a jump of its zero.
    pub tripod_may_have_moved: bool,
    /// A zero or a tripod that wanders in a smooth course explains it nearly as well.
    pub may_wander: bool,
}

/// A station's zero that wanders smoothly. A tripod that sways does nearly the same to the lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WanderingZero {
    /// The station.
    pub station: usize,
    /// Rms of its course over the occupation, mm.
    pub rms_mm: f64,
}

impl Screened {
    /// All readings with full weight in one adjustment, and the noise that they show.
    ///
    /// # Errors
    /// Those of the adjustment.
    pub fn plain(network: &Network, declared: bool) -> Result<Self, Error> {
        let kept = (0..network.readings.len()).collect();
        Self::adjusted(network.clone(), kept, declared)
    }

    /// The same readings in other groups: those that `found` kept, occupations split where it splits them. Nothing is sought
    /// again; the noise is what this network shows.
    ///
    /// # Errors
    /// Those of the adjustment.
    pub fn as_found(network: &Network, declared: bool, found: &Self) -> Result<Self, Error> {
        let without: Vec<usize> = found.removed.iter().map(|r| r.reading).collect();
        let (mut network, kept) = network.without(&without);
        network
            .interruptions
            .clone_from(&found.network.interruptions);
        Ok(Self {
            removed: found.removed.clone(),
            jumps: found.jumps.clone(),
            wandering: found.wandering.clone(),
            settled: found.settled,
            ..Self::adjusted(network, kept, declared)?
        })
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
            settled: true,
            tests: None,
        })
    }

    /// The tests of every reading and visit of the network: how far the others check each.
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
