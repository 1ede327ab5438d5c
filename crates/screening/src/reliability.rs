//! Internal reliability: which error of a length would be found.
//!
//! Baarda's test finds an error `∇` with the power `1 - β` at the level `α` if it is at least
//!
//! ```text
//! ∇₀ = (z_{1-α/2} + z_{1-β}) σ_∇
//! ```
//!
//! with the standard deviation `σ_∇` of its estimate. The level is that of the screening ([`crate::screen`]): by
//! chance the largest of all lengths exceeds the limit in one of a hundred campaigns.

use trueaxis_leastsquares::chi_squared_quantile;

use crate::screened::Screened;
use crate::search::reading_limit;

/// The conventional power of a minimal detectable error.
const POWER: f64 = 0.8;

impl Screened {
    /// Smallest error of a reading that screening finds with a probability of 80 %, in standard deviations of its
    /// estimate ([`ReadingTest::sigma_mm`](trueaxis_multilateration::ReadingTest::sigma_mm)).
    pub fn minimal_detectable(&self) -> f64 {
        with_power(reading_limit(self.network.readings.len()))
    }
}

/// The limit of a test with the power of a minimal detectable error.
pub(crate) fn with_power(limit: f64) -> f64 {
    // z_p is the root of the chi-squared quantile of 2p - 1 with one degree of freedom.
    limit + chi_squared_quantile(2.0 * POWER - 1.0, 1.0).sqrt()
}
