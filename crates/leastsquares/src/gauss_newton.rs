//! Gauss–Newton with step control on the true cost.

use crate::arrowhead::{Arrowhead, Correction};
use crate::covariance::Covariance;
use crate::error::Error;
use crate::reduced::Datum;

/// A model that linearises itself.
pub trait Adjustment {
    /// Values of all unknowns.
    type State: Clone;

    /// Eliminates every block of the system, linearised at `state`, in a fixed order, and says
    /// what the datum is there.
    ///
    /// # Errors
    /// Those of [`Arrowhead::eliminate`].
    fn linearise(&self, state: &Self::State) -> Result<(Arrowhead, Datum), Error>;

    /// Sum of squares of the whitened residuals at `state`, with the weights of
    /// [`Adjustment::linearise`].
    fn squares(&self, state: &Self::State) -> f64;

    /// `state` moved by `factor` times the correction.
    fn moved(&self, state: &Self::State, correction: &Correction, factor: f64) -> Self::State;
}

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Most iterations.
    pub max_iterations: usize,
    /// Converged when the whole correction is shorter than this, in units of standard
    /// uncertainty: no result then moves by more than this fraction of its `u`.
    pub correction_tol: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            max_iterations: 50,
            correction_tol: 1e-6,
        }
    }
}

/// Why the iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Termination {
    /// The last correction, in units of standard uncertainty, was below the tolerance.
    Converged {
        /// Its length.
        correction: f64,
        /// The tolerance.
        tolerance: f64,
    },
    /// No shorter step along the correction lowers the cost, and the correction is longer than
    /// rounding explains.
    NoDecrease {
        /// Length of the correction in units of standard uncertainty.
        correction: f64,
    },
    /// The most iterations were used up.
    MaxIterations {
        /// Length of the last correction in units of standard uncertainty.
        correction: f64,
    },
}

impl Termination {
    /// Whether the result is the minimum.
    pub fn is_converged(&self) -> bool {
        matches!(self, Self::Converged { .. })
    }
}

impl std::fmt::Display for Termination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Converged {
                correction,
                tolerance,
            } => write!(
                f,
                "converged: last correction {correction:.1e} standard uncertainties, limit {tolerance:.0e}"
            ),
            Self::NoDecrease { correction } => write!(
                f,
                "stuck: no step lowers the cost, correction {correction:.1e} standard uncertainties"
            ),
            Self::MaxIterations { correction } => write!(
                f,
                "iterations used up, last correction {correction:.1e} standard uncertainties"
            ),
        }
    }
}

/// The adjusted unknowns with the evidence.
#[derive(Debug, Clone)]
pub struct Adjusted<S> {
    /// Values of all unknowns.
    pub state: S,
    /// Sum of squares of the whitened residuals.
    pub squares: f64,
    /// Number of rows.
    pub observations: usize,
    /// Number of unknowns less the free motions that the datum fixes.
    pub unknowns: usize,
    /// Iterations used.
    pub iterations: usize,
    /// Why it stopped. A result that is not converged is returned, not hidden.
    pub termination: Termination,
    /// Covariance of all unknowns for unit variance of the whitened rows.
    pub covariance: Covariance,
}

/// Halvings of a step before giving up: 2⁻²⁰ of a correction is no progress.
const MAX_HALVINGS: usize = 20;

/// A cost may rise by this fraction from rounding alone.
const COST_ROUNDING: f64 = 1e-10;

/// Adjusts the unknowns of `model` from `start`.
///
/// # Errors
/// Those of [`Arrowhead::eliminate`] and [`Arrowhead::solve`]. Not converging is no error; see
/// [`Adjusted::termination`].
pub fn adjust<M: Adjustment>(
    model: &M,
    start: M::State,
    settings: &Settings,
) -> Result<Adjusted<M::State>, Error> {
    let mut state = start;
    let mut iterations = 0;
    loop {
        let (system, datum) = model.linearise(&state)?;
        let (observations, unknowns) = (system.rows(), system.determined_unknowns());
        let solved = system.solve(&datum)?;
        let correction = solved.predicted_decrease.max(0.0).sqrt();
        iterations += 1;

        let accepted = descend(model, &state, &solved.correction, solved.squares);
        let tolerance = settings.correction_tol;
        let termination = match &accepted {
            _ if correction <= tolerance => Some(Termination::Converged {
                correction,
                tolerance,
            }),
            // What is left to gain is less than the cost resolves.
            None if correction <= (COST_ROUNDING * solved.squares).sqrt() => {
                Some(Termination::Converged {
                    correction,
                    tolerance: (COST_ROUNDING * solved.squares).sqrt(),
                })
            }
            None => Some(Termination::NoDecrease { correction }),
            Some(_) if iterations >= settings.max_iterations => {
                Some(Termination::MaxIterations { correction })
            }
            Some(_) => None,
        };
        let (next, squares) = accepted.unwrap_or((state, solved.squares));
        state = next;
        if let Some(termination) = termination {
            let covariance = solved.covariance;
            return Ok(Adjusted {
                state,
                squares,
                observations,
                unknowns,
                iterations,
                termination,
                covariance,
            });
        }
    }
}

/// The longest of the steps 1, 1/2, 1/4, … of a correction that does not raise the cost.
fn descend<M: Adjustment>(
    model: &M,
    state: &M::State,
    correction: &Correction,
    squares: f64,
) -> Option<(M::State, f64)> {
    let mut factor = 1.0;
    for _ in 0..=MAX_HALVINGS {
        let candidate = model.moved(state, correction, factor);
        let candidate_squares = model.squares(&candidate);
        // A candidate without a finite cost fails this, too.
        if candidate_squares <= squares * (1.0 + COST_ROUNDING) + f64::MIN_POSITIVE {
            return Some((candidate, candidate_squares));
        }
        factor *= 0.5;
    }
    None
}
