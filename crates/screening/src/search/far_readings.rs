//! Readings that are far from the others: at the start, and by redescending weights.

use trueaxis_leastsquares::median;
use trueaxis_multilateration::{Network, ReadingTest, Start};

use super::{MAX_ROUNDS, READINGS_LEVEL, Search, WELSCH_ITERATIONS};
use crate::Error;
use crate::robust_weights::{REMOVED, welsch};

/// A length is far off if its distance from what the nominal positions predict exceeds this many times the median of
/// all distances; and at least this, mm.
const FAR: f64 = 10.0;
const FAR_MM: f64 = 1.0;

/// Readings that are far off at the start, and by how much (mm).
pub(super) fn far_at(start: &Start, network: &Network) -> Vec<(usize, f64)> {
    let mut sizes_mm = start.residuals_mm(network);
    sizes_mm.iter_mut().for_each(|r| *r = r.abs());
    let typical_mm = median(&mut sizes_mm.clone()).unwrap_or(0.0);
    let limit_mm = (FAR * typical_mm).max(FAR_MM);
    let sizes = sizes_mm.into_iter().enumerate();
    sizes.filter(|&(_, size_mm)| size_mm > limit_mm).collect()
}

impl Search {
    /// Releases far readings: the width of the weights starts at the largest distance, at most `widest` times the
    /// spread, and is halved until it is the spread. Starting at the spread would keep any few lengths that agree by
    /// chance (graduated non-convexity).
    pub(super) fn let_go(
        &mut self,
        widest: f64,
        distances: impl Fn(&[ReadingTest]) -> Vec<f64>,
    ) -> Result<(), Error> {
        let mut width = f64::INFINITY;
        let mut final_rounds = 0;
        for _ in 0..MAX_ROUNDS {
            if final_rounds == WELSCH_ITERATIONS || self.is_lost() {
                break;
            }
            let (tests, _) = self.tests()?;
            let spread = self.spread(&tests.readings);
            let distances = distances(&tests.readings);
            let largest = distances.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
            width = (0.5 * width).min(largest).min(widest * spread).max(spread);
            final_rounds += usize::from(width <= spread);
            self.inflation = distances.iter().map(|t| welsch(t / width)).collect();
            self.solve()?;
        }
        Ok(())
    }

    pub(super) fn redescend(&mut self) -> Result<(), Error> {
        self.let_go(f64::INFINITY, |tests| {
            tests.iter().map(|test| test.w).collect()
        })?;
        let (tests, spread) = self.tests()?;
        let limit = self.limit(READINGS_LEVEL) * spread;
        let factor = |test: &ReadingTest| if test.w.abs() > limit { REMOVED } else { 1.0 };
        self.inflation = tests.readings.iter().map(factor).collect();
        self.solve()
    }
}
