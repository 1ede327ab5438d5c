//! Redundancy numbers and internal reliability: how far the others check a length, and which error of it
//! would be noticed.
//!
//! Baarda's test finds an error `∇` with the power `1 - β` at the level `α` if it is at least
//!
//! ```text
//! ∇₀ = (z_{1-α/2} + z_{1-β}) σ_∇
//! ```
//!
//! with the standard deviation `σ_∇` of its estimate. The level is that of the screening
//! ([`crate::screen`]): the limit that all lengths together pass by chance in one of a hundred
//! campaigns.

use std::sync::Arc;

use trueaxis_leastsquares::chi_squared_quantile;
use trueaxis_multilateration::ReadingTest;

use crate::screened::Screened;
use crate::search::reading_limit;

/// How well the others check one reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reliability {
    /// Redundancy number ([`ReadingTest::redundancy`]).
    pub redundancy: f64,
    /// Baarda's w ([`ReadingTest::w`]).
    pub standardized: f64,
    /// Smallest error that screening finds with a probability of 80 %, mm; infinite where nothing
    /// checks the reading.
    pub minimal_detectable_mm: f64,
}

/// The power for which a minimal detectable error is given, by convention.
const POWER: f64 = 0.8;

impl Screened {
    /// Reliability of every reading of the network.
    pub fn reliability(&self) -> Arc<Vec<Reliability>> {
        let known = self.reliability.clone();
        known.unwrap_or_else(|| Arc::new(of_tests(&self.solution.tests(&self.network).readings)))
    }
}

/// Reliability of all readings of a network, from their tests.
pub(crate) fn of_tests(tests: &[ReadingTest]) -> Vec<Reliability> {
    // z_p is the root of the chi-squared quantile of 2p - 1 with one degree of freedom.
    let power = chi_squared_quantile(2.0 * POWER - 1.0, 1.0).sqrt();
    let factor = reading_limit(tests.len()) + power;
    let reliability = |test: &ReadingTest| Reliability {
        redundancy: test.redundancy,
        standardized: test.w,
        minimal_detectable_mm: factor * test.sigma_mm,
    };
    tests.iter().map(reliability).collect()
}
