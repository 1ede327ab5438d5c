//! Redescending weights let go of readings that are far from the others.

use super::{MAX_ROUNDS, READINGS_LEVEL, Screening, WELSCH_ITERATIONS};
use crate::Error;
use crate::baarda::ReadingTest;
use crate::robust_weights::{REMOVED, welsch};

impl Screening<'_> {
    /// Lets go of far readings: the width of the weights starts at the largest distance, `widest`
    /// times the scale at most, and is halved until it is the scale. A start at the scale would keep
    /// any few lengths that agree by chance (graduated non-convexity).
    pub(crate) fn let_go(
        &mut self,
        widest: f64,
        distances: impl Fn(&[ReadingTest]) -> Vec<f64>,
    ) -> Result<(), Error> {
        let mut width = f64::INFINITY;
        let mut settled = 0;
        for _ in 0..MAX_ROUNDS {
            if settled == WELSCH_ITERATIONS || self.is_lost() {
                break;
            }
            let (tests, _) = self.tests()?;
            let scale = self.scale(&tests.readings);
            let distances = distances(&tests.readings);
            let largest = distances.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
            width = (0.5 * width).min(largest).min(widest * scale).max(scale);
            settled += usize::from(width <= scale);
            self.network.variance_factors = distances.iter().map(|t| welsch(t / width)).collect();
            self.solve()?;
        }
        Ok(())
    }

    pub(super) fn redescend(&mut self) -> Result<(), Error> {
        self.let_go(f64::INFINITY, |tests| {
            tests.iter().map(|test| test.w).collect()
        })?;
        let (tests, scale) = self.tests()?;
        let limit = self.limit(READINGS_LEVEL) * scale;
        let factor = |test: &ReadingTest| if test.w.abs() > limit { REMOVED } else { 1.0 };
        self.network.variance_factors = tests.readings.iter().map(factor).collect();
        self.solve()
    }
}
