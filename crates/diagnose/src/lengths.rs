//! The level of the tracker's lengths.
//!
//! The base model is the joint adjustment with rigid stages
//! ([`trueaxis_multilateration::solve`]): six pose parameters for each step, common to all
//! stations, repeats and directions; target shapes common to all steps; stations and dead paths. No geometry of a
//! rigid machine that returns to its poses can explain what contradicts this model. The noise is that of a length and
//! that of the machine's repeatability, common to a stop (restricted maximum likelihood from the residuals).
//!
//! - [`base`] has the lengths; [`adjust`] adjusts them ([`adjusted`]) with the full nonlinear model, less the effects
//!   of the causes so far; the parameters of the causes follow by block elimination until both converge.
//! - [`measured`]: the lengths as the search for causes ([`crate::engine`]) needs them.
//! - [`beside`]: disturbances join the covariance.
//! - [`instead`]: a machine that shifts may also be a tripod that jumps, and a scale of lengths a machine that was larger.
//! - [`omnibus`]: whether anything is left at all, and what it varies with ([`unexplained`]).
//! - [`left_out`]: gross errors leave before the search, and return if the causes explain them.
//! - [`search`]: from the lengths to causes; [`named`]: the causes that explain enough of the misfit.
//! - [`held_out`]: the gain on sweeps, and on whole stations, not used for the fit.
//! - [`report`] combines everything.

mod adjust;
mod adjusted;
mod base;
mod beside;
mod fitted;
mod held_out;
mod instead;
mod left_out;
mod measured;
mod named;
mod noise_floor;
mod not_observable;
mod omnibus;
mod places;
mod report;
mod search;
mod swapped;
mod unexplained;

pub(crate) use report::diagnose_lengths;
pub(crate) use trueaxis_poses::scene_of as scene;
