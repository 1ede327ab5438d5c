//! What the values of one output say.

use crate::coverage::{self, Interval, Ranks};
use crate::error::Error;
use crate::moments::Moments;

/// One output: summary of its distribution (JCGM 101, 5.3), in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Mean of the values: the estimate of the output.
    pub mean: f64,
    /// Standard deviation of the values (n - 1): the standard uncertainty.
    pub u: f64,
    /// Probabilistically symmetric coverage interval: as many values below as above.
    pub symmetric: Interval,
    /// Shortest coverage interval. Its ends scatter more than those of the symmetric one: with the
    /// cube root of the number of trials, not the square root, where the density has its mode
    /// inside.
    pub shortest: Interval,
    /// Scatter of mean, u and symmetric interval from one seed to another.
    pub scatter: Scatter,
}

/// Scatter that a finite number of trials leaves in the results of one output, as standard
/// deviations in the unit of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scatter {
    /// Of the mean.
    pub mean: f64,
    /// Of the standard uncertainty.
    pub u: f64,
    /// Of the lower end of the symmetric coverage interval.
    pub low: f64,
    /// Of the upper end.
    pub high: f64,
}

impl Scatter {
    /// The largest of the four.
    pub fn largest(&self) -> f64 {
        self.mean.max(self.u).max(self.low).max(self.high)
    }
}

impl Summary {
    /// Summary of output number `output`, given its values in the order of the trials; leaves them
    /// sorted.
    pub(crate) fn of(output: usize, values: &mut [f64], ranks: Ranks) -> Result<Self, Error> {
        let moments = Moments::of(values);
        let (mean, u) = (moments.mean, moments.standard_deviation());
        let u_scatter = moments.standard_deviation_scatter(values);
        if !(mean.is_finite() && u.is_finite() && u_scatter.is_finite()) {
            return Err(Error::Overflow { output });
        }
        values.sort_unstable_by(f64::total_cmp);
        Ok(Self {
            mean,
            u,
            symmetric: coverage::symmetric(values, ranks),
            shortest: coverage::shortest(values, ranks),
            scatter: Scatter {
                mean: moments.mean_scatter(),
                u: u_scatter,
                low: coverage::order_statistic_scatter(values, ranks.r),
                high: coverage::order_statistic_scatter(values, ranks.r + ranks.q),
            },
        })
    }
}
