//! How large the smooth rest of a curve may be, from the other curves of the machine.
//!
//! A slope or a single wave is judged by the low frequencies of its own curve, of which there are only three or four.
//! But curves of one kind (translations, angles) on one machine are alike in size: the logarithms of their s scatter
//! about a common μ with the standard deviation τ,
//!
//! ```text
//! p(s) ∝ Σ_μ N(ln s; μ, τ²) Π_others ∫ N(ln s'; μ, τ²) L(s') d ln s'
//! ```
//!
//! on the grid of s, flat in exp μ. The curve itself does not enter its prior, so an effect in it does not inflate
//! its own rest. Without other curves the prior is flat in s.

use std::collections::BTreeMap;

use crate::components::background::{Background, size};
use crate::components::judgement::ln_sum;

/// Logarithm of the prior mass of each size of the smooth rest, by its index in the grid.
#[derive(Debug, Clone, Default)]
pub(crate) struct SmoothPrior {
    ln_mass: Option<BTreeMap<i32, f64>>,
}

/// Logarithm of the likelihood of a curve over the sizes of its smooth rest.
#[derive(Debug, Clone)]
pub(crate) struct SmoothLikelihood(BTreeMap<i32, f64>);

/// τ: two curves of one kind on one machine typically differ by a factor of three.
const SPREAD: f64 = 1.0;

/// Number of grid sizes beyond those of the others: four τ; farther out the prior is flat.
const BEYOND: i32 = 12;

impl SmoothPrior {
    /// The prior of a curve from the likelihoods of the others; flat in s if there are none.
    pub(crate) fn from_others(others: &[&SmoothLikelihood]) -> Self {
        let numbers = || others.iter().flat_map(|other| other.0.keys().copied());
        let (Some(low), Some(high)) = (numbers().min(), numbers().max()) else {
            return Self::default();
        };
        // μ, and s some τ beyond the range of the others.
        let apart = |a: i32, b: i32| size(a - b).ln() / SPREAD;
        let ln_normal = |a: i32, b: i32| -0.5 * apart(a, b).powi(2);
        let posterior: Vec<(i32, f64)> = (low..=high)
            .map(|mean| {
                let of_one = |other: &&SmoothLikelihood| {
                    let sizes: Vec<f64> = (low..=high)
                        .filter_map(|k| Some(other.at(k)? + ln_normal(k, mean)))
                        .collect();
                    ln_sum(sizes.iter().copied())
                };
                let likelihood: f64 = others.iter().map(of_one).sum();
                (mean, likelihood + size(mean).ln())
            })
            .collect();
        let mass = |k: i32| ln_sum(posterior.iter().map(|(mean, p)| p + ln_normal(k, *mean)));
        let range = low - BEYOND..=high + BEYOND;
        Self {
            ln_mass: Some(range.map(|k| (k, mass(k))).collect()),
        }
    }

    /// Logarithm of the prior mass of the size with this index.
    pub(crate) fn ln_mass(&self, number: i32) -> f64 {
        let Some(known) = &self.ln_mass else {
            // In equal ratios a point represents an interval in proportion to s.
            return size(number).ln();
        };
        let ends = known.first_key_value().zip(known.last_key_value());
        let end = ends.map(|(first, last)| if number < *first.0 { first.1 } else { last.1 });
        known.get(&number).or(end).copied().unwrap_or(0.0)
    }
}

impl SmoothLikelihood {
    /// The likelihood from all sizes of the rest of a curve.
    pub(crate) fn new(backgrounds: &[Background]) -> Self {
        let mut of_sizes: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
        for background in backgrounds {
            let own = of_sizes.entry(background.smooth).or_default();
            own.push(background.ln_likelihood);
        }
        let sums = of_sizes.into_iter();
        Self(
            sums.map(|(k, terms)| (k, ln_sum(terms.iter().copied())))
                .collect(),
        )
    }

    /// Logarithm of the likelihood at an index: below the smallest size it is constant, above the largest it is zero.
    fn at(&self, number: i32) -> Option<f64> {
        let (lowest, value) = self.0.first_key_value()?;
        if number < *lowest {
            Some(*value)
        } else {
            self.0.get(&number).copied()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Others that are certainly near one size make this size and its neighbours likely.
    #[test]
    fn others_say_what_is_likely() {
        let sharp = SmoothLikelihood([(4, -200.0), (5, 0.0), (6, -200.0)].into());
        let prior = SmoothPrior::from_others(&[&sharp, &sharp, &sharp, &sharp]);
        let density = |k: i32| prior.ln_mass(k);
        assert!(density(5) > density(4) && density(5) > density(6));
        assert!(density(12) < density(5) - 2.0);
    }

    #[test]
    fn alone_it_is_flat() {
        let prior = SmoothPrior::from_others(&[]);
        let ratio = (prior.ln_mass(3) - prior.ln_mass(1)).exp();
        assert!((ratio - size(2)).abs() < 1e-12);
    }
}
