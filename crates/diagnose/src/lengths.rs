//! The level of the tracker's lengths.
//!
//! The base model is the joint adjustment with rigid stages
//! ([`trueaxis_multilateration::solve`]): six pose parameters for each step, common to all
//! stations, repeats and directions; target shapes common to all steps; stations and dead paths. What
//! the lengths contradict in it, no geometry of a rigid machine that comes back to its poses can
//! explain. The noise is that of a length and that of the machine's repeatability, common to a stop
//! (restricted maximum likelihood from the residuals).
//!
//! - [`base`] are the lengths; [`adjust`] adjusts them ([`adjusted`]), less what the causes found so far do to them, with the full
//!   nonlinear model; the parameters of the causes follow by block elimination until both converge.
//! - [`weighed`]: stations whose lengths scatter more weigh less.
//! - [`measured`]: what the search for causes ([`crate::engine`]) asks of them.
//! - [`beside`]: what wanders in a course that nobody knows joins the covariance.
//! - [`grown`]: what scales all lengths of a station is a machine that was larger then, too.
//! - [`shifted`]: a machine that shifts while one station is occupied is a tripod that jumps, too.
//! - [`omnibus`]: whether anything is left at all, and what it varies with ([`unexplained`]).
//! - [`left_out`]: gross errors leave before the search, and come back if the causes explain them.
//! - [`search`]: from the lengths to causes; [`named`]: which of them explain enough of what is there.
//! - [`held_out`]: the gain on sweeps, and on whole stations, that the model was not fitted to.
//! - [`report`] puts it together.

mod adjust;
mod adjusted;
mod base;
mod beside;
mod fitted;
mod grown;
mod held_out;
mod left_out;
mod measured;
mod named;
mod noise_floor;
mod not_observable;
mod omnibus;
mod places;
mod report;
mod search;
mod shifted;
mod swapped;
mod unexplained;
mod weighed;

pub(crate) use report::diagnose_lengths;
pub(crate) use trueaxis_poses::scene_of as scene;
