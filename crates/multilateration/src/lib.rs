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
//! Points are eliminated group by group, so time and memory are linear in the lengths. Lengths
//! leave position, orientation and the mirror image of the whole free: position and orientation
//! are those that fit the points best to their nominal positions (inner constraints), and the
//! nominal positions choose the image. Stations need no approximate position.
//!
//! Noun in: a [`Network`]; noun out: a [`Solution`] with points, stations, residuals and the
//! covariance of everything. [`screen`] does the same without gross errors and lost counts, with the
//! noise that the residuals show ([`estimate_noise`]). [`network_from_campaign`] makes the network of
//! a measuring campaign; [`Trials`] solves a network again and again with other errors, for Monte
//! Carlo. Lengths are mm in any right-handed frame. The crate does not say why lengths are wrong
//! beyond that.
//!
#![doc = "```"]
#![doc = include_str!("../examples/solve.rs")]
#![doc = "```"]

mod adjustment;
mod baarda;
mod batch_influence;
mod batches;
mod beams;
mod block_noise;
mod bodies;
mod components;
mod datum;
mod distances;
mod error;
mod estimate_noise;
mod from_campaign;
mod guard;
mod interruption;
mod known;
mod lane_vectors;
mod linearise;
mod memory;
mod network;
mod noise;
mod passes;
mod pieces;
mod reflector_set;
mod reflectors;
mod reliability;
mod robust_weights;
mod screen;
mod screened;
mod screening;
mod slots;
mod solution;
mod solve;
mod splits;
mod start;
mod state;
mod step_tests;
mod tie;
mod trials;
mod undetermined;
mod visit_weights;
mod whitened;

pub use block_noise::BlockNoise;
pub use bodies::{Bodies, Body, Placed};
pub use distances::{Distances, Pair};
pub use error::{Error, Part, StationUnknown};
pub use estimate_noise::{NoiseBasis, NoiseEstimate, PartEstimate, estimate_noise};
pub use from_campaign::{CampaignNetwork, Group, network_from_campaign};
pub use guard::MOST_OF_A_PART;
pub use network::{Interruption, KnownDeadPath, Network, Reading, Visit};
pub use noise::Noise;
pub use reflector_set::{USUAL_DIFFERENCE_MM, adjust_as_a_set, solve_as_a_set};
pub use reflectors::{Reflectors, contrast};
pub use reliability::Reliability;
pub use screen::screen;
pub use screened::{Jump, Removed, Screened, WanderingZero};
pub use solution::{Solution, Station};
pub use solve::{Refined, Settings, refine, solve, solve_from};
pub use trials::{Corrections, Trials, Workspace};
pub use whitened::Whitened;
