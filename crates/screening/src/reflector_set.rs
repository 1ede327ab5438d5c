//! Reflectors whose constants the lengths do not determine: they count as those of one set.

use std::sync::Arc;

use trueaxis_multilateration::{Error, Network, Reflectors, Solution, solve, solve_from};

/// Largest difference between the constants of a set of laser-tracker reflectors, mm.
pub const USUAL_DIFFERENCE_MM: f64 = 5e-3;

/// Whether the lengths determine the constants less well than the fact that the reflectors are of one set; linear
/// propagation would be wrong there.
fn are_open(solution: &Solution) -> bool {
    solution.reflector_covariance().diagonal().amax() > USUAL_DIFFERENCE_MM.powi(2)
}

/// Adjusts a network by `adjust`. If its lengths leave the constants of the reflectors open, and no σ of theirs is
/// known, the network gets [`USUAL_DIFFERENCE_MM`] as that σ and is adjusted again.
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

/// Solves a network, starting from a solution of a similar one if given; see [`adjust_as_a_set`].
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
