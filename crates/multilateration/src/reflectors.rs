//! Constants of the reflectors: every length to one of them is longer by its constant.
//!
//! ```text
//! l = |p - S| - L + k_r
//! ```
//!
//! What all constants have in common is dead path. The unknowns are therefore `K - 1` contrasts `a` of the `K`
//! constants, with orthonormal columns of sum zero (Helmert's):
//!
//! ```text
//! k = H a     1ᵀH = 0     HᵀH = I
//! ```
//!
//! so that constants are relative to their mean, and no reflector is preferred. Constants that are drawn
//! independently with a standard deviation `σ` have contrasts that are, too.

use std::sync::Arc;

use crate::{Error, Network, Settings, Solution, solve, solve_from};

/// Which reflector stands at each point of a network.
#[derive(Debug, Clone, PartialEq)]
pub struct Reflectors {
    /// Number of reflectors.
    pub count: usize,
    /// Standard deviation of the constants of a set, where it is known, mm: each contrast is then observed to
    /// be zero with it.
    pub sigma_mm: Option<f64>,
    /// The reflector at each point, in the order of the network.
    pub of_points: Vec<usize>,
}

impl Reflectors {
    /// Number of unknowns.
    pub fn contrasts(&self) -> usize {
        self.count.saturating_sub(1)
    }

    /// Checks that each point has one that is there.
    pub(crate) fn check(&self, points: usize) -> Result<(), Error> {
        if self
            .sigma_mm
            .is_some_and(|sigma| !sigma.is_finite() || sigma <= 0.0)
        {
            return Err(Error::Malformed {
                what: "the standard deviation of reflectors is not positive and finite".to_owned(),
            });
        }
        let found = self.of_points.len();
        let largest = self.of_points.iter().max();
        if found != points || largest.is_some_and(|&r| r >= self.count) {
            return Err(Error::Malformed {
                what: format!(
                    "reflectors are named for {found} of {points} points, of {}",
                    self.count
                ),
            });
        }
        Ok(())
    }
}

/// Reflectors of a set for a laser tracker differ by no more, mm.
pub const USUAL_DIFFERENCE_MM: f64 = 5e-3;

/// Whether lengths tell less of the constants than that the reflectors are of one set: what they would leave of
/// them is more than these differ by, and linear propagation is wrong there. Constants that are known beforehand
/// are not open.
fn are_open(network: &Network, solution: &Solution) -> bool {
    let of_set = network.reflectors.as_ref();
    let is_known = of_set.is_none_or(|reflectors| reflectors.sigma_mm.is_some());
    let largest = solution.reflector_covariance().diagonal().amax();
    !is_known && largest > USUAL_DIFFERENCE_MM.powi(2)
}

/// Adjusts a network by `adjust`; where its lengths leave the constants of the reflectors open, and nothing is known
/// of these, they are taken for those of a set: the network then has [`USUAL_DIFFERENCE_MM`] as what is known.
///
/// # Errors
/// Those of the second adjustment, if there is one.
pub fn adjust_as_a_set<T>(
    network: &mut Network,
    solution: impl Fn(&T) -> &Solution,
    adjust: impl Fn(&Network) -> Result<T, Error>,
) -> Result<T, Error> {
    let adjusted = adjust(network);
    let unknown = network.reflectors.as_deref();
    let unknown = unknown.filter(|reflectors| reflectors.sigma_mm.is_none());
    let is_good = |adjusted: &T| {
        let solution = solution(adjusted);
        solution.termination.is_converged() && !are_open(network, solution)
    };
    match unknown {
        Some(unknown) if !adjusted.as_ref().is_ok_and(is_good) => {
            let of_a_set = Reflectors {
                sigma_mm: Some(USUAL_DIFFERENCE_MM),
                ..unknown.clone()
            };
            network.reflectors = Some(Arc::new(of_a_set));
            adjust(network)
        }
        _ => adjusted,
    }
}

/// Solves a network, from a solution of a similar one if there is one; see [`adjust_as_a_set`].
///
/// # Errors
/// Those of [`solve`].
pub fn solve_as_a_set(
    network: &mut Network,
    near: Option<&Solution>,
    settings: &Settings,
) -> Result<Solution, Error> {
    adjust_as_a_set(
        network,
        |solution| solution,
        |network| match near {
            Some(near) => solve_from(network, near, settings),
            None => solve(network, settings),
        },
    )
}

/// `H`: what a unit of contrast `m` does to the constant of a reflector.
pub fn contrast(reflector: usize, m: usize) -> f64 {
    let before = (m + 1) as f64;
    let length = (before * (before + 1.0)).sqrt();
    match reflector {
        r if r <= m => 1.0 / length,
        r if r == m + 1 => -before / length,
        _ => 0.0,
    }
}

/// The constants that belong to contrasts, mm.
pub(crate) fn constants_mm(contrasts_mm: &[f64]) -> Vec<f64> {
    let constant = |r: usize| {
        let all = contrasts_mm.iter().enumerate();
        all.map(|(m, a)| contrast(r, m) * a).sum()
    };
    match contrasts_mm.len() {
        0 => Vec::new(),
        n => (0..=n).map(constant).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrasts_are_orthonormal_and_have_no_mean() {
        const COUNT: usize = 8;
        for m in 0..COUNT - 1 {
            let sum: f64 = (0..COUNT).map(|r| contrast(r, m)).sum();
            assert!(sum.abs() < 1e-15);
            for n in 0..COUNT - 1 {
                let product: f64 = (0..COUNT).map(|r| contrast(r, m) * contrast(r, n)).sum();
                let expected = f64::from(u8::from(m == n));
                assert!((product - expected).abs() < 1e-15, "{m} {n}");
            }
        }
    }
}
