//! Reflectors whose constants the lengths do not tell: they are of one set.

use std::sync::Arc;

use crate::reflectors::Reflectors;
use crate::solution::Solution;
use crate::solve::{solve, solve_from};
use crate::{Error, Network};

/// Reflectors of a set for a laser tracker differ by no more, mm.
pub const USUAL_DIFFERENCE_MM: f64 = 5e-3;

/// Whether lengths tell less of the constants than that the reflectors are of one set: what they would leave of
/// them is more than these differ by, and linear propagation is wrong there.
fn are_open(solution: &Solution) -> bool {
    solution.reflector_covariance().diagonal().amax() > USUAL_DIFFERENCE_MM.powi(2)
}

/// Adjusts a network by `adjust`; where its lengths leave the constants of the reflectors open, and nothing is known
/// of these, they are taken for those of a set: the network then has [`USUAL_DIFFERENCE_MM`] as what is known.
///
/// # Errors
/// Those of the second adjustment, if there is one.
pub fn adjust_as_a_set<T, E>(
    network: &mut Network,
    solution: impl Fn(&T) -> &Solution,
    adjust: impl Fn(&Network) -> Result<T, E>,
) -> Result<T, E> {
    let adjusted = adjust(network);
    let unknown = network.reflectors.as_deref();
    let unknown = unknown.filter(|reflectors| reflectors.sigma_mm.is_none());
    let is_good = |adjusted: &T| {
        let solution = solution(adjusted);
        solution.termination.is_converged() && !are_open(solution)
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
pub fn solve_as_a_set(network: &mut Network, near: Option<&Solution>) -> Result<Solution, Error> {
    adjust_as_a_set(
        network,
        |solution| solution,
        |network| match near {
            Some(near) => solve_from(network, near),
            None => solve(network),
        },
    )
}
