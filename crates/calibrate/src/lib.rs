//! All geometric errors of a machine tool from a measuring campaign.
//!
//! From lengths to (or coordinates of) three targets on each axis' stage come the poses of the stages
//! (`trueaxis-poses`; by default in one adjustment of all lengths with rigid stages). Every measured pose is
//! explained by the exact machine model
//!
//! ```text
//! P = T1(q1) … Tk(qk) H        T: commanded motion, location errors, component errors
//! ```
//!
//! (`H`: the targets at home on their stage). Each axis' component errors, its location errors and the home positions
//! of the targets follow in the least-squares gauge: location errors are those of the average line or axis of
//! rotation, component errors are what is left.
//!
//! Noun in: a [`trueaxis_campaign::Campaign`] and [`Settings`]; noun out: a [`Calibration`] with standard
//! uncertainties propagated from the noise of the poses. The steps of [`calibrate()`] are
//!
//! 1. measure: campaign → poses with their covariance ([`trueaxis_poses::measure()`]), sorted by the axis
//!    under test;
//! 2. identify: from average lines and axes (`trueaxis-fitting`) Newton's method on the pose, axis after axis
//!    from the bed outwards, with the gauge and the reference frame applied in every pass, until the model
//!    reproduces the measured poses;
//! 3. propagate: every result as a linear function of the errors of the poses;
//! 4. report: results, contradictions, and notices for the user.
//!
//! Nothing after the first step depends on how the poses were found.
//!
//! # The reference frame
//!
//! With two linear axes that are not parallel (x before y before z): the average line of the first has its nominal
//! direction, the average line of the second lies in the plane of the two nominal directions. The origin is such that
//! the home positions of the targets are, in the mean, their nominal positions. With one linear axis the rotation
//! about it, with none the whole frame follows from the best fit of the targets' home positions to the nominal ones.
//!
//! An axis measured while others stand away from home is corrected for their known errors.
//!
//! # Uncertainties
//!
//! Each standard uncertainty comes with its [`Budget`] and its degrees of freedom
//! ([`trueaxis_predict::coverage_factor`]), all results together with their covariance in factors
//! ([`trueaxis_predict::FactoredCovariance`]), on request as one matrix ([`trueaxis_predict::OutputCovariance`]).
//!
//! [`Calibration::calibrated_machine`] predicts the errors anywhere (`trueaxis-predict`).
//!
//! # Repeating the same campaign
//!
//! [`calibrate_for_replay`] keeps what is needed to repeat the calibration with new errors: Monte Carlo and
//! reliability ([`Replay`]). [`calibrate_with_effects`] removes effects beyond the rigid machine (drift, jumps, lost
//! motion) from the lengths, and adds the uncertainty of their values to that of the results.
//!
//! # What it does not do
//!
//! It does not measure, and it does not say why a model fails (`trueaxis-diagnose` does).
//!
#![doc = "```"]
#![doc = include_str!("../examples/calibrate.rs")]
#![doc = "```"]

mod calibrate;
mod error;
mod explain;
mod files;
mod identify;
mod in_order;
mod matrix_size;
mod propagate;
mod replay;
mod report;
mod result;
mod settings;

pub use calibrate::{calibrate, calibrate_with_adjustment};
pub use error::Error;
pub use explain::mistake_behind;
pub use replay::reliability::{LengthReliability, LengthsReliability};
pub use replay::run_comparison::{ComparedPose, RunComparison};
pub use replay::with_effects::calibrate_with_effects;
pub use replay::{Replay, Responses, calibrate_for_replay};
pub use result::budget::Budget;
pub use result::calibration::{
    AxisResult, Calibration, LocationResult, MethodLoss, NodeResult, RelativeLocation,
    RelativeQuantity, RunMisfit, StationResult, TargetResult, Traceability, TriangleSide,
    UncertaintyStatement,
};
pub use result::numbered::NumberedResult;
pub use settings::{ReferencePoint, Settings};
pub use trueaxis_poses::Method;
