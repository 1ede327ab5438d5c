//! Gauss–Newton with step control on the true cost.

use crate::covariance::Covariance;
use crate::error::Error;
use crate::factors::Factors;
use crate::free_gauge::Correction;
use crate::reduced::Reduced;

/// A model that linearises itself.
///
/// A pass over the blocks linearises and [reduces](Self::reduce) them; when the shared unknowns are known, the next one
/// [moves](Self::step) each with what this one has left and, but for the last step, [reduces](Self::step_and_reduce) it
/// again where it then is.
/// Weights may depend on the state: each iteration has those of its own start, and the step that it leads to is
/// judged with them. The datum decides only among results that fit as well: they are [placed](Self::apply_datum) on
/// it when they are found, and its [constraints](Self::reduce_with_datum) are needed for the covariance alone.
pub trait Adjustment {
    /// Values of all unknowns.
    type State: Clone;

    /// What a linearisation leaves to the step that follows: the weights, and the eliminated blocks. The memory
    /// serves all iterations.
    type Linearised: Default;

    /// The reduced system without constraints, linearised at `state` with the weights that belong to it, with
    /// the sum of squares there; bits must not depend on the number of threads.
    fn reduce(
        &self,
        state: &Self::State,
        linearised: &mut Self::Linearised,
    ) -> Result<Reduced, Error>;

    /// The same with the constraints of the datum, and the factors of all blocks.
    fn reduce_with_datum(&self, state: &Self::State) -> Result<(Reduced, Factors), Error>;

    /// Writes to `next` the `state` moved by `factor` times the correction that belongs to that of the
    /// shared unknowns, `s`, from the system linearised at `state`; the sum of squares there, with the weights of
    /// that system, whether or not it can be reduced there.
    fn step(
        &self,
        from: (&Self::State, &mut Self::Linearised),
        s: &[f64],
        factor: f64,
        next: &mut Self::State,
    ) -> f64;

    /// A whole [step](Self::step), and the [reduced](Self::reduce) system where it leads. What the linearisation at
    /// `state` has left is replaced.
    ///
    /// # Errors
    /// As [`Adjustment::reduce`], of the system alone.
    fn step_and_reduce(
        &self,
        from: (&Self::State, &mut Self::Linearised),
        s: &[f64],
        next: &mut Self::State,
    ) -> (f64, Result<Reduced, Error>);

    /// For each constraint of the datum a motion that changes no observation: its part in the shared
    /// unknowns.
    fn free_motions(&self, state: &Self::State) -> Vec<Vec<f64>>;

    /// Takes everything as a whole to where the constraints of the datum hold; no observation changes.
    fn apply_datum(&self, state: &mut Self::State);
}

/// Why the iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Termination {
    /// The correction that would follow, in units of standard uncertainty, is below the tolerance.
    Converged {
        /// Its length by estimate: that of the last one times the rate at which they become shorter,
        /// or of the last one itself where no rate is known.
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
                "converged: next correction {correction:.1e} standard uncertainties, limit {tolerance:.0e}"
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
}

impl<S: Clone> Adjusted<S> {
    /// Covariance of all unknowns for unit variance of the whitened rows of the adjusted `model`.
    pub fn covariance<M: Adjustment<State = S>>(&self, model: &M) -> Result<Covariance, Error> {
        let (system, factors) = model.reduce_with_datum(&self.state)?;
        let reduced = system.solve(|| model.free_motions(&self.state))?;
        Ok(Covariance::new(factors, reduced))
    }
}

/// Most iterations.
const MAX_ITERATIONS: usize = 50;

/// Converged when the correction that would follow, by estimate, is shorter than this, in units of
/// standard uncertainty: no result would then move by more than about this fraction of its `u`.
const CORRECTION_TOL: f64 = 1e-6;

/// Halvings of a step before giving up: 2⁻²⁰ of a correction is no progress.
const MAX_HALVINGS: usize = 20;

/// A cost may rise by this fraction from rounding alone.
const COST_ROUNDING: f64 = 1e-10;

/// Corrections of which each is more than this part of the one before say nothing of those that follow.
const MOST_RATE: f64 = 0.1;

/// Short corrections of which each of three is more than this part of the one before mostly come from rounding: exact
/// lengths leave a standard uncertainty of which rounded distances show no millionth.
const STANDING: f64 = 0.3;

/// Corrections are short up to this length, in units of standard uncertainty.
const SHORT: f64 = 1e-4;

/// Adjusts the unknowns of `model` from `start`.
///
/// A step is judged by the true cost where it leads, with the weights where it began. The last one is taken without this
/// check, if the next would be below the tolerance: that is estimated as the last step times its ratio to the one before
/// (P. Deuflhard, *Newton Methods for Nonlinear Problems*, chapter 4). In the end the ratio is that of the direction that
/// shrinks least; the first ratio says little of it, because a start may lie in any direction, so two whole steps must
/// come before.
///
/// # Errors
/// Those of [`Adjustment::reduce`] and [`Reduced::shortest_correction`]. Not converging is no error; see
/// [`Adjusted::termination`].
pub fn adjust<M: Adjustment>(model: &M, start: &M::State) -> Result<Adjusted<M::State>, Error> {
    let (mut state, mut next) = (start.clone(), start.clone());
    let mut linearised = M::Linearised::default();
    let mut iterations = 0;
    // Lengths of the corrections since a step was shortened.
    let mut whole_steps: Vec<f64> = Vec::new();
    let mut corrections: Vec<f64> = Vec::new();
    let mut system = model.reduce(&state, &mut linearised)?;
    loop {
        let motions = model.free_motions(&state);
        let shortest = system.shortest_correction(&motions)?;
        let correction = shortest.decrease.max(0.0).sqrt();
        let rate = match whole_steps[..] {
            [.., _, last] if correction < MOST_RATE * last => correction / last,
            _ => 1.0,
        };
        let mut squares = system.squares;
        iterations += 1;

        let stands = match corrections[..] {
            [.., a, b] => a.max(b) <= SHORT && b > STANDING * a && correction > STANDING * b,
            _ => false,
        };
        corrections.push(correction);
        let from = (&state, &mut linearised);
        let (left, tolerance) = match stands {
            true => (correction, SHORT),
            false => (rate * correction, CORRECTION_TOL),
        };
        let termination = if left <= tolerance {
            squares = model.step(from, &shortest.shared, 1.0, &mut next);
            std::mem::swap(&mut state, &mut next);
            Termination::Converged {
                correction: left,
                tolerance,
            }
        } else {
            match descend(model, from, &shortest, squares, &mut next)? {
                Some((squares_there, factor, system_there)) => {
                    std::mem::swap(&mut state, &mut next);
                    squares = squares_there;
                    match factor < 1.0 {
                        true => whole_steps.clear(),
                        false => whole_steps.push(correction),
                    }
                    if iterations < MAX_ITERATIONS {
                        system = system_there?;
                        continue;
                    }
                    Termination::MaxIterations { correction }
                }
                // What is left to gain is less than the cost resolves.
                None if correction <= (COST_ROUNDING * squares).sqrt() => Termination::Converged {
                    correction,
                    tolerance: (COST_ROUNDING * squares).sqrt(),
                },
                None => Termination::NoDecrease { correction },
            }
        };
        model.apply_datum(&mut state);
        return Ok(Adjusted {
            state,
            squares: squares.max(0.0),
            observations: system.observations,
            unknowns: system.unknowns() - motions.len(),
            iterations,
            termination,
        });
    }
}

/// The sum of squares after a step, the part of the correction that it is, and the reduced system there.
type Descent = (f64, f64, Result<Reduced, Error>);

/// Takes to `next` the longest of the steps 1, 1/2, 1/4, … that does not raise the cost.
fn descend<M: Adjustment>(
    model: &M,
    (state, linearised): (&M::State, &mut M::Linearised),
    shortest: &Correction,
    squares: f64,
    next: &mut M::State,
) -> Result<Option<Descent>, Error> {
    let limit = squares * (1.0 + COST_ROUNDING) + f64::MIN_POSITIVE;
    // Without a finite cost this is false, too.
    let is_lower = |squares_there: f64| squares_there <= limit;
    let s = &shortest.shared;
    let (squares_there, system) = model.step_and_reduce((state, linearised), s, next);
    if is_lower(squares_there) {
        return Ok(Some((squares_there, 1.0, system)));
    }
    model.reduce(state, linearised)?;
    let mut factor = 1.0;
    for _ in 0..MAX_HALVINGS {
        factor *= 0.5;
        let squares_there = model.step((state, linearised), s, factor, next);
        if is_lower(squares_there) {
            let system = model.reduce(next, linearised);
            return Ok(Some((squares_there, factor, system)));
        }
    }
    Ok(None)
}
