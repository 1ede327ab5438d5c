//! The parts of a misfit, in squares, so that they add up to one.
//!
//! With `S₀` the squares of the base model, the drop by a cause is averaged over all orders in which the causes can
//! enter (Shapley), so that the order in which they were found does not matter:
//!
//! ```text
//! share of cause k = max(0, φ_k - columns of k)/S₀      noise = ν/S₀      unexplained = the rest
//! ```
//!
//! A disturbance takes what causes and stronger disturbances leave: it enters after them, with the prior of its
//! coefficients, and counts as many columns as the data determine (`Σ x/(1 + x)`). `ν` are the degrees of freedom
//! that are left. If no test finds anything left, the rest is noise.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use trueaxis_selection::Projection;

use crate::json::rounded;

/// The parts of a misfit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Shares {
    /// Of each cause, in the order of the causes.
    #[serde(serialize_with = "rounded::sixths")]
    pub causes: Vec<f64>,
    /// Of each disturbance, in their order.
    #[serde(serialize_with = "rounded::sixths")]
    pub disturbances: Vec<f64>,
    /// What no cause explains.
    #[serde(serialize_with = "rounded::sixth")]
    pub unexplained: f64,
    /// What noise alone would leave.
    #[serde(serialize_with = "rounded::sixth")]
    pub noise: f64,
}

impl Shares {
    /// The shares of causes, then of disturbances, in a base model, each by its whitened columns: free coefficients, or
    /// such with the prior `N(0, 1)`; `is_left` if a test finds something beside them.
    pub(crate) fn of_parts(
        base: &Projection,
        causes: impl Iterator<Item = Vec<Vec<f64>>>,
        disturbances: impl Iterator<Item = Vec<Vec<f64>>>,
        is_left: bool,
    ) -> Self {
        // Each model is that of the subset without its last part, extended by this part.
        let mut models = vec![base.clone()];
        for columns in causes {
            let more = models.par_iter().map(|model| model.extended(&columns));
            models.extend(more.collect::<Vec<_>>());
        }
        let causes = models.len().ilog2() as usize;
        for columns in disturbances {
            let more = models.par_iter().map(|model| model.beside(&columns).0);
            models.extend(more.collect::<Vec<_>>());
        }
        let parts = models.len().ilog2() as usize;
        let subsets: Vec<(f64, f64)> = models
            .iter()
            .map(|model| (model.squares(), model.degrees_of_freedom - model.taken))
            .collect();
        let all = subsets[0].0.max(f64::MIN_POSITIVE);
        let after = subsets[subsets.len() - 1];
        // The drop by each part beyond the expected drop by noise.
        let gained = |subset: usize, k: usize| {
            let (without, with) = (subsets[subset], subsets[subset | 1 << k]);
            (without.0 - with.0) - (without.1 - with.1)
        };
        let share = |k: usize| {
            if k >= causes {
                // After all causes and the preceding disturbances.
                return (gained((1 << k) - 1, k) / all).max(0.0);
            }
            let without = (0..1 << causes).filter(|subset: &usize| subset >> k & 1 == 0);
            let mean: f64 = without
                .map(|subset| gained(subset, k) * order_weight(subset.count_ones(), causes))
                .sum();
            (mean / all).max(0.0)
        };
        let mut shares: Vec<f64> = (0..parts).map(share).collect();
        let sum: f64 = shares.iter().sum();
        if sum > 1.0 {
            shares.iter_mut().for_each(|share| *share /= sum);
        }
        let disturbances = shares.split_off(causes);
        let rest = (1.0 - sum).max(0.0);
        let noise = if is_left {
            rest.min(after.1 / all)
        } else {
            rest
        };
        Self {
            causes: shares,
            disturbances,
            unexplained: rest - noise,
            noise,
        }
    }

    /// With at least this share unexplained, of what noise was thought to leave: where noise is what is left of all, it
    /// contains what has no cause.
    pub(crate) fn with_unexplained(mut self, share: f64) -> Self {
        let more = (share - self.unexplained).min(self.noise).max(0.0);
        self.unexplained += more;
        self.noise -= more;
        self
    }
}

/// Share of the orders of `count` parts in which exactly a given set of `before` comes first: `s! (n - s - 1)!/n!`.
fn order_weight(before: u32, count: usize) -> f64 {
    let s = before as usize;
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    factorial(s) * factorial(count - s - 1) / factorial(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orthogonal columns explain 9 and 4, less one each; two equal columns share what one explains.
    #[test]
    fn shares_add_up_and_do_not_depend_on_the_order() {
        let unit = |k: usize| {
            (0..6)
                .map(|i| f64::from(u8::from(i == k)))
                .collect::<Vec<_>>()
        };
        let base = Projection::dense(vec![3.0, 2.0, 1.0, 1.0, 1.0, 1.0], &[]);
        let of_two = |k| [0, k].into_iter().map(|k| vec![unit(k)]);
        let shares = Shares::of_parts(&base, of_two(1), std::iter::empty(), true);
        assert!((shares.causes[0] - 8.0 / 17.0).abs() < 1e-12, "{shares:?}");
        assert!((shares.causes[1] - 3.0 / 17.0).abs() < 1e-12, "{shares:?}");
        assert!((shares.noise - 4.0 / 17.0).abs() < 1e-12, "{shares:?}");
        let sum = shares.causes.iter().sum::<f64>() + shares.unexplained + shares.noise;
        assert!((sum - 1.0).abs() < 1e-12, "{shares:?}");
        let twice = Shares::of_parts(&base, of_two(0), std::iter::empty(), false);
        assert!((twice.causes[0] - twice.causes[1]).abs() < 1e-12);
        assert!((twice.causes[0] - 4.0 / 17.0).abs() < 1e-12, "{twice:?}");
        assert!(twice.unexplained.abs() < 1e-12);
    }
}
