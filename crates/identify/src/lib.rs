//! Six component errors of a machine tool axis from three measured points.
//!
//! A stage that moves as a rigid body displaces the target at `r_j` by
//!
//! ```text
//! Δ_j = δ + ε × r_j        j = P, Q, K        (paper Eqs. 20 and 21)
//! ```
//!
//! Three targets off one line give nine such equations ①...⑨ (Px Py Pz Qx Qy Qz Kx Ky Kz; Eq. 9
//! for a linear, Eq. 16 for a rotary axis) for the six components of δ and ε. Noun in: the measured
//! points of a step, with their noise; noun out: the pose of its stage ([`pose_from_points`], a
//! [`MeasuredPose`]). Its parts can be used alone, too. An [`Operator`] leads from generalised coordinates `r_j`
//! (Eq. 19) and volumetric errors `Δ_j` (measured minus ideal position) to a
//! [`MotionError`](trueaxis_kinematics::MotionError), and knows its noise gain:
//!
//! - [`nine()`] and [`nine_weighted`]: all equations by least squares, for three targets or more;
//! - [`SixRows`]: any six of the nine (the paper's are Eqs. 10 and 17), for comparison.
//!
//! Lengths are mm, angles rad, right-hand rule. δ belongs to the origin of `r`, and its noise grows with the distance
//! of the targets from that point.
//!
#![doc = "```"]
#![doc = include_str!("../examples/nine.rs")]
#![doc = "```"]
//!
//! [`rigid_misfit`] tests whether the points of a step moved as one body.
//!
//! The crate does not measure points, and its results contain squareness and other location errors: separating these
//! needs all steps of a run.

mod body;
mod covariance;
mod design;
mod error;
mod misfit;
mod nine;
mod operator;
mod pose;
mod rigid_factors;
mod six_rows;

pub use body::{BodyNoise, BodyPoseNoise, BodyPoses, BodyStep, StepPose, poses_of_body};
pub use design::equations;
pub use error::{Error, StepError};
pub use misfit::{RigidMisfit, rigid_misfit};
pub use nine::{nine, nine_weighted};
pub use operator::Operator;
pub use pose::{Equations, MeasuredPose, StepPoints, pose_from_points};
pub use six_rows::SixRows;
