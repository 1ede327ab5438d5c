//! The level of measured coordinates.
//!
//! A campaign of points has three coordinates of each target at each stop, in the frame of any rigid instrument.
//! The base model is that of the joint adjustment without stations: six pose parameters for each step, common to all
//! repeats and sides of approach, and the shape of the targets of each stage, common to all steps,
//!
//! ```text
//! p = T_step h_target + noise
//! ```
//!
//! with the noise of the instrument, which may depend on place and direction, and the machine's repeatability, common to
//! a stop ([`noise`]). Targets on the bed stand still. The model can be contradicted by distances between targets of one stage
//! (three targets or more), repeats, and the two sides of approach. Everything is linear about one adjustment: poses
//! are known to micrometres, and effects are as small.
//!
//! - [`readings`]: time, place and sweep of each point.
//! - [`base`]: the adjustment, its derivatives, and the effects of the catalogue on the coordinates.
//! - [`noise`], [`model`], [`variances`]: whitening stop by stop, elimination of the poses, restricted maximum
//!   likelihood, with different variances in three directions if the residuals demand it.
//! - [`weighed`]: targets that scatter more than the others have less weight.
//! - [`gross_errors`]: points that contradict all others leave, before the search and beside its causes.
//! - [`mod@wrong_points`]: those that `calibrate` leaves out, too.
//! - [`doubted`]: whether too many points contradict the others for that.
//! - [`measured`]: the points as the search for causes ([`crate::engine`]) needs them. A frame that moves as a whole
//!   cannot be distinguished from a machine that does: both are always given.
//! - [`beside`]: disturbances join the covariance.
//! - [`omnibus`]: whether anything is left, and what it varies with.
//! - [`believed`]: the causes that are named.
//! - [`held_out`]: the gain on sweeps not used for the fit.
//! - [`report`] combines everything; [`fitted`], [`places`] and [`not_observable`] report it with units.

mod base;
mod believed;
mod beside;
mod doubted;
mod fitted;
mod gross_errors;
mod held_out;
mod measured;
mod model;
mod noise;
mod not_observable;
mod omnibus;
mod places;
mod readings;
mod report;
mod screened;
mod variances;
mod weighed;
mod wrong_points;

pub(crate) use report::diagnose_points;
pub use wrong_points::{KeptWrongPoint, WithoutWrongPoints, without_wrong_points};
