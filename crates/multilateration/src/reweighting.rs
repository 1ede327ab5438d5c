//! Adjustments whose weights depend on what they find.
//!
//! The machine's return correlates the lengths of a visit by the directions of their beams, and the noise
//! of a length may grow with it. Weights are made at the start; the adjustment moves the beams; so they
//! are made again, until they have settled.

use trueaxis_leastsquares::{Adjusted, Adjustment};

use crate::Error;

/// Weights settle at once: beams move by far less than their length, and weights by that part.
const MOST_UPDATES: usize = 10;

/// Stations and points that moved by less since the weights were made, relative to the size of the network,
/// leave them as they are. Weights that are wrong by such a part change a result by the same part of its
/// standard uncertainty, a tenth of what the iteration tolerates.
const SETTLED: f64 = 1e-7;

/// An adjustment that takes its weights from beams.
pub(crate) trait Reweighted: Adjustment {
    /// Whether weights depend on the beams at all.
    fn weights_follow_beams(&self) -> bool;

    /// Takes the weights from the beams at `state`.
    fn update_weights(&mut self, state: &Self::State);

    /// By how much a station or point moved at most, relative to the size of the network.
    fn moved(&self, from: &Self::State, to: &Self::State) -> f64;
}

/// Goes on from a first adjustment, the weights of which are those of the beams at `start`, until they are
/// those of the result; `run` adjusts again. Returns the number of all iterations with the result.
///
/// # Errors
/// Those of `run`.
pub(crate) fn reweight<M: Reweighted>(
    model: &mut M,
    mut start: M::State,
    first: Adjusted<M::State>,
    run: impl Fn(&M, M::State) -> Result<Adjusted<M::State>, Error>,
) -> Result<(Adjusted<M::State>, usize), Error> {
    let mut adjusted = first;
    let mut iterations = adjusted.iterations;
    if !model.weights_follow_beams() {
        return Ok((adjusted, iterations));
    }
    for _ in 0..MOST_UPDATES {
        if !adjusted.termination.is_converged() || model.moved(&start, &adjusted.state) <= SETTLED {
            break;
        }
        model.update_weights(&adjusted.state);
        start.clone_from(&adjusted.state);
        adjusted = run(model, adjusted.state)?;
        iterations += adjusted.iterations;
    }
    Ok((adjusted, iterations))
}
