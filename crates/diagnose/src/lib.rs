//! What a calibrated model of a machine gets wrong in the measured data, and why.
//!
//! A calibration explains measured lengths by a rigid, quasi-static machine and a tracker that stands
//! still. Reality adds drifts, jumps, slips, bending and lost motion. With everything that the model
//! absorbs projected out of the whitened lengths,
//!
//! ```text
//! e = M y      T(h) = sᵀ G⁺ s      s = X_hᵀ e      G = X_hᵀ M X_h
//! ```
//!
//! every effect `h` in the catalogue (`trueaxis-effects`) is a hypothesis with columns `X_h`. The verb answers four
//! questions: *what* is wrong (omnibus tests, the misfit by groups of readings), *why* (one cause, or several that
//! the data cannot separate, or honestly unknown), what the *better model* is (parameters, changes of the
//! calibration), and what is *gained* on unused data.
//!
//! Noun in: a [`trueaxis_campaign::Campaign`]; noun out: a [`Diagnosis`]. Its levels are the tracker's lengths, or
//! measured coordinates, the readings of other instruments (positioning lines, ball bars), and the calibrated error
//! curves themselves, which contradict nothing and do not enter the verdict. The method and how often it is right:
//! `docs/diagnosis.md` of the repository.
//!
//! It does not measure again: it cannot see what leaves no trace in the data ([`NotObservable`]), and it never calls
//! that absent.
//!
#![doc = "```"]
#![doc = include_str!("../examples/diagnose.rs")]
#![doc = "```"]

mod cause;
mod changes;
mod components;
mod diagnose;
mod diagnosis;
mod disturbance;
mod engine;
mod error;

mod fitted;
mod json;
mod lengths;
mod numbers;
mod points;
mod runs;
mod said;
mod settings;
mod shares;
mod verification;

pub use cause::{Cause, Change, EstimatedParameter, Follows, LostMotionAt, Rival};
pub use diagnose::{diagnose, diagnose_against};
pub use diagnosis::{
    Diagnosis, Gain, HeldOutRatio, LevelReport, Misfit, NotObservable, OmnibusTest, Place,
    Rejected, Unexplained, Verdict,
};
pub use disturbance::{CorrelationLength, CurvePoint, Disturbance, Wandering};
pub use error::Error;
pub use fitted::{Against, Fitted, FittedPoint};
pub use points::{KeptWrongPoint, WithoutWrongPoints, without_wrong_points};
pub use settings::Settings;
pub use shares::Shares;
