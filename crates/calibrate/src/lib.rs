//! All geometric errors of a machine tool from a measuring campaign.
//!
//! From the lengths (or coordinates) of three targets on each axis' stage, every measured pose is
//! explained by the exact machine model
//!
//! ```text
//! p = T1(q1) … Tk(qk) r        T: commanded motion, location errors, component errors
//! ```
//!
//! and each axis' component errors, its location errors and the home positions of the targets
//! follow in the least-squares gauge: location errors are what the average line or axis of
//! rotation takes, component errors are what is left.
//!
//! Noun in: a [`trueaxis_campaign::Campaign`]; noun out: a [`Calibration`] with standard
//! uncertainties propagated from the lengths. The path is lengths → points
//! (`trueaxis-multilateration`) → pose errors by the nine equations (`trueaxis-identify`) → average
//! lines and axes (start: `trueaxis-fitting`) → gauge and reference frame, repeated until the exact
//! model reproduces the measured poses.
//!
//! # The reference frame
//!
//! With two linear axes that are not parallel (x before y before z): the average line of the first
//! one has its nominal direction, the average line of the second lies in the plane of the two
//! nominal directions. The origin is where the targets on their stage are at home, in the mean, at
//! their nominal positions. With one linear axis the rotation about it, with none the whole frame
//! follows from the best fit of the targets' home positions to the nominal ones.
//!
//! An axis measured while others stand away from home is freed of their errors as far as they are
//! known.
//!
//! # Uncertainties
//!
//! Everything is linear in the points' errors, and these in the noise of the lengths and of the
//! machine's return. Each standard uncertainty comes with its [`Budget`] and its degrees of freedom
//! ([`coverage_factor`]); on request the covariance of all results together
//! ([`OutputCovariance`]), and with it that of the volumetric error
//! ([`Calibration::volumetric_error_at`]).
//!
//! # Gross errors, noise, trials
//!
//! Lengths that contradict the others leave, interrupted turns are split, and the noise is estimated
//! from what is left ([`trueaxis_multilateration::screen`]; [`AdjustmentReport`] says what was done).
//! [`calibrate_for_replay`] keeps what other errors of the same measurement need: Monte Carlo and
//! reliability.
//!
//! # Effects that are known
//!
//! [`calibrate_with_effects`] takes what effects beyond the rigid machine do (drift, jumps, lost motion)
//! out of the lengths, and lets the uncertainty of their values into that of the results.
//!
//! # What it does not do
//!
//! It does not say why a model fails. Points are not screened, and their noise is only tested.
//!
//! ```
//! use trueaxis_calibrate::{Settings, calibrate};
//! use trueaxis_simulate::{Scenario, simulate};
//!
//! let scenario = Scenario::from_json(include_str!("../../../campaigns/rotary-stage/scenario.json"))?;
//! let simulated = simulate(&scenario, 1)?;
//! let calibration = calibrate(&simulated.campaign, &Settings::default())?;
//! let c = calibration.axis("C").ok_or("C was not measured")?;
//! let tilt = c.location_error("A0C").ok_or("no A0C")?;
//! println!("A0C = {:.2e} rad, standard uncertainty {:.1e} rad", tilt.value, tilt.u);
//! assert!(tilt.u < 1e-5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod added_uncertainty;
mod adjustment_file;
mod adjustment_report;
mod axis_data;
mod axis_noise;
mod axis_twist;
mod base_response;
mod basis;
mod budget;
mod calibrate;
mod calibration;
mod covariance_files;
mod describe;
mod error;
mod frame;
mod frame_forms;
mod frame_map;
mod from_lengths;
mod from_points;
mod gauge;
mod identify_axes;
mod in_order;
mod interpolation;
mod json;
mod length_circumstances;
mod lengths_in_words;
mod measure;
mod method_loss;
mod nine;
mod node_records;
mod output_covariance;
mod output_entry;
mod points;
mod points_report;
mod pose_errors;
mod poses;
mod reliability;
mod reliability_files;
mod replay;
mod results;
mod rigid_fit;
mod rigidity;
mod settings;
mod sides;
mod sources;
mod start;
mod state;
mod triangle;
mod twist;
mod uncertainty;
mod variance;
mod volumetric;
mod weak_stations;
mod with_effects;

pub use adjustment_report::{
    AdjustmentReport, InterruptedTurn, NoiseReport, PartReport, RejectedLength,
};
pub use budget::{Budget, coverage_factor};
pub use calibrate::{LengthsAdjustment, calibrate, calibrate_with_adjustment};
pub use calibration::{
    AxisResult, Calibration, LocationResult, MethodLoss, NodeResult, SideDifference, StationResult,
    StepMisfit, TargetResult, TriangleSide,
};
pub use error::Error;
pub use length_circumstances::{LengthCircumstances, Observation, length_circumstances, scene_of};
pub use output_covariance::{Output, OutputCovariance, Unit};
pub use output_entry::OutputEntry;
pub use reliability::{LengthReliability, LengthsReliability};
pub use replay::{Replay, ReplayWorkspace, calibrate_for_replay};
pub use results::NumberedResult;
pub use settings::{Method, ReferencePoint, Settings};
pub use volumetric::VolumetricError;
pub use with_effects::calibrate_with_effects;
