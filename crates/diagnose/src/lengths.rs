//! The level of the tracker's lengths.
//!
//! The base model is the joint adjustment with rigid stages
//! ([`trueaxis_multilateration::solve_rigid`]): six pose parameters for each step, common to all
//! stations, repeats and directions; target shapes common to all steps; stations and dead paths. What
//! the lengths contradict in it, no geometry of a rigid machine that comes back to its poses can
//! explain. The noise is that of a length and that of the machine's return, common to a stop
//! (restricted maximum likelihood from the residuals).
//!
//! One round of the search:
//!
//! 1. [`Base::adjust`]: the lengths, less what the causes found so far do to them, are adjusted with the
//!    full nonlinear model; the parameters of the causes follow by block elimination until both rest.
//! 2. [`hypotheses`]: every effect of the catalogue on every subject becomes whitened columns; instants
//!    are profiled over all visits by running sums ([`step_scan`]).
//! 3. The leader is the hypothesis with the most evidence; the noise is estimated again with it in the
//!    model and the ranking repeated, since a disturbance that is large blurs its own rivals.
//! 4. It joins the causes if noise alone would not do as well once in a hundred campaigns.
//!
//! Afterwards causes that the others made superfluous leave again, the omnibus tests say whether
//! anything is left ([`omnibus`]), and the gain is measured on sweeps that were left out
//! ([`held_out`]).

mod base;
mod harmonics;
mod held_out;
mod hypotheses;
mod noise_floor;
mod not_observable;
mod omnibus;
mod places;
mod readings;
mod search;
mod step_scan;
mod unexplained;

pub(crate) use search::{LengthsOutcome, diagnose_lengths};
