//! Measured poses of a machine's stages, from lengths or from coordinates.
//!
//! A pose is the rigid motion that brings the targets of a stage from home to where they were at a step. Its
//! error is a small twist `x = (δ, ε)`: a translation (mm) of a pivot and a rotation (rad) about it. The errors
//! of all poses are
//!
//! ```text
//! x_i = ξ_i - Z_i s     cov(x_i, x_k) = [i = k] D_i + Z_i Σ Z_kᵀ
//! ```
//!
//! with a part of its own for each pose and one through what all poses share: stations, dead paths, the shapes of the
//! targets, the datum.
//!
//! Noun in: a checked [`trueaxis_campaign::Campaign`] and [`Settings`]; noun out: [`MeasuredPoses`], the [`Poses`]
//! with what was adjusted beside them. There are three methods; later stages need not know which was used:
//!
//! - [`Method::Joint`]: one adjustment of all lengths with rigid stages
//!   (`trueaxis-multilateration`), in which every pose is an unknown;
//! - [`Method::Nine`]: lengths → points, each free of the others → poses by the nine equations of each step
//!   (`trueaxis-identify`, paper Eqs. 20 and 21); the paper's path;
//! - [`Method::Six`]: the same with six of the nine.
//!
//! Coordinates that an instrument measured directly are moved into the datum; their poses follow from the equations,
//! with noise that depends on place and direction as the coordinates show ([`trueaxis_screening::CoordinateNoise`]).
//!
//! Before that, lengths that contradict the others are removed, interrupted occupations are split, and the noise is
//! estimated from the rest ([`trueaxis_screening::screen`]); [`AdjustmentReport`] says what was done. [`PoseTrials`]
//! repeats the measurement with new errors, for Monte Carlo and reliability.
//! [`EffectsOnLengths`] takes what known effects do (drift, jumps, lost motion) out of the lengths.
//!
#![doc = "```"]
#![doc = include_str!("../examples/measure.rs")]
#![doc = "```"]
//!
//! # What it does not do
//!
//! It knows neither errors of axes nor a reference frame: poses are in the datum, the best fit of all targets to
//! their nominal positions. Measured coordinates are not screened; their noise is tested, and estimated where the
//! test fails or nothing is declared.

mod error;
mod lengths;
mod measure;
mod missing;
mod points;
mod poses;
mod report;
mod residual;
mod settings;
mod trials;
mod words;

pub use error::Error;
pub use lengths::{
    CampaignNetwork, EffectsOnLengths, Group, LengthCircumstances, LengthsAdjustment, Observation,
    ReflectorConstant, ScaleBasis, ScaleResult, SideDifference, at_one_temperature,
    constant_feed_per_s, length_circumstances, network_from_campaign, scene_of,
    temperature_histories, uneven_in_words,
};
pub use measure::{MeasuredPoses, NoiseByEquations, measure};
pub use missing::missing;
pub use poses::{
    PoseNoise, PoseObservation, Poses, TargetBody, ThroughSources, turned_about, twist_map,
};
pub use report::{
    AdjustmentReport, InterruptedOccupation, KnownMisfit, NoiseReport, PartReport, RejectedLength,
    StepMisfit, TurnedRuns,
};
pub use residual::Residual;
pub use settings::{Method, Settings};
pub use trials::{PoseTrials, Trial, TrialWorkspace};
pub use trueaxis_multilateration::Station;
pub use trueaxis_screening::{MOST_REMOVED, NoiseBasis};
pub use words::{MIN_TARGETS, step_in_words};
