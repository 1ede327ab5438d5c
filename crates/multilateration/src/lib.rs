//! Self-calibrating sequential multilateration with one laser tracker.
//!
//! One tracker measures incremental lengths to the same points from several stations `S_j`, each
//! with an unknown zero, the dead path `L_j`:
//!
//! ```text
//! l_ij = |p_i - S_j| - L_j + e_ij
//! ```
//!
//! One least-squares adjustment finds points, stations and dead paths at once (paper section 3).
//! Points are eliminated group by group, so time and memory are linear in the lengths. Lengths leave position,
//! orientation and the mirror image of the whole free: position and orientation are chosen so that the points fit
//! their nominal positions best (inner constraints), and the nominal positions choose the image. Stations need no
//! approximate position.
//!
//! Noun in: a [`Network`]; noun out: a [`Solution`] with points, stations, residuals and the
//! covariance of everything. [`Trials`] solves a network again and again with new errors, for Monte Carlo. Lengths
//! are mm in any right-handed frame.
//!
//! Further analysis starts from the solution: [`Solution::tests`] (is a length wrong?),
//! [`Solution::own_shapes`] (did the targets move as a rigid body?),
//! [`Solution::variance_components`] (what noise do the residuals show?), and [`Whitened`], the rows of the hat matrix,
//! for all else.
//!
#![doc = "```"]
#![doc = include_str!("../examples/solve.rs")]
#![doc = "```"]
//!
//! # What it does not do
//!
//! It takes lengths as they are: gross errors, interruptions and the noise are found by `trueaxis-screening`. It knows no
//! machine and no files; `trueaxis-poses` makes the network of a campaign.

mod adjustment;
mod baarda;
mod batch_influence;
mod batches;
mod beams;
mod block_noise;
mod bodies;
mod chunks;
mod components;
mod datum;
mod distances;
mod error;
mod known;
mod lane_vectors;
mod linearise;
mod memory;
mod network;
mod noise;
mod own_shapes;
mod passes;
mod reflectors;
mod returns;
mod slots;
mod solution;
mod solve;
mod start;
mod state;
mod tie;
mod trials;
mod undetermined;
mod visit_weights;
mod whitened;

pub use baarda::{CHECKED_TOL, ReadingTest, Tests};
pub use block_noise::BlockNoise;
pub use bodies::{Bodies, Body, Placed, are_in_line};
pub use components::VarianceComponents;
pub use distances::{Distances, Pair};
pub use error::{Error, StationUnknown};
pub use network::{Interruption, KnownDeadPath, Network, Reading, Visit};
pub use noise::Noise;
pub use own_shapes::{OwnShapeTest, OwnShapes};
pub use reflectors::{Reflectors, contrast};
pub use returns::Return;
pub use solution::{Solution, Station};
pub use solve::{
    MIN_STATIONS, MIN_STATIONS_PER_POINT, Refined, refine, solve, solve_from, solve_with_noise,
};
pub use start::Start;
pub use trials::{Corrections, Trials, Workspace};
pub use whitened::Whitened;
