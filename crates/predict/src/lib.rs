//! The errors of a calibrated machine anywhere, and how well they are known.
//!
//! A calibration knows the component errors of each axis at its steps, its location errors, and the covariance of all
//! ([`FactoredCovariance`]). With the exact rigid motions of [`trueaxis_kinematics::Machine`] the error of the tool
//! against the workpiece follows for any positions `q` of the axes and any tool point, to first order in the errors `x`
//!
//! ```text
//! e(q) = Σ_tool twist - Σ_workpiece twist = J(q) x      cov = J cov(x) Jᵀ + K diag(u_interpolation²) Kᵀ
//! ```
//!
//! Between the steps component errors are interpolated by local cubics, whose uncertainty is estimated by leaving a step
//! out.
//!
//! Noun in: `calibration.json` with `covariance.npz` beside it ([`CalibratedMachine::read`]), or what a calibration
//! found ([`CalibratedMachine::new`]); noun out: the [`CalibratedMachine`] with
//!
//! - its error at any place ([`CalibratedMachine::predict`]), with one axis approached from one side ([`Approach`]);
//! - the volumetric error over the working volume ([`CalibratedMachine::volume`]);
//! - what a laser interferometer or a ball bar reads on it ([`predicted_reading_um`],
//!   [`CalibratedMachine::covariance_of_readings`]);
//! - the difference of two calibrations ([`CalibratedMachine::compare`]).
//!
//! Lengths are mm, angles rad; files have the units that their field names carry. Standard uncertainties are k = 1;
//! [`coverage_factor`] is that of an interval.
//!
#![doc = "```"]
#![doc = include_str!("../examples/predict.rs")]
#![doc = "```"]
//!
//! # What it does not do
//!
//! It does not calibrate (`trueaxis-calibrate`) and corrects nothing (`trueaxis-compensate`). No stated uncertainty contains
//! errors that the steps do not resolve, nor those of axes that were not measured ([`CalibratedMachine::unmeasured`]).

mod approach;
mod calibrated_machine;
mod common_line;
mod compare;
mod coverage_factor;
mod curve;
mod factored_covariance;
mod files;
mod interpolation;
mod knots;
mod output;
mod pivoted_cholesky;
mod predict;
mod read_out;
mod readings;
mod remainder;
mod same_machine;
mod sensitivities;
mod volume;

pub use approach::Approach;
pub use calibrated_machine::{CalibratedMachine, MeasuredAxis};
pub use compare::{Difference, OtherReferencePoint, stands_alike};
pub use coverage_factor::coverage_factor;
pub use factored_covariance::FactoredCovariance;
pub use files::comparison_json::comparison_json;
pub use files::predicted_csv::{ERROR_COLUMNS, to_csv};
pub use files::read_error::{CovarianceProblem, ReadError};
pub use interpolation::{Node, weights_at};
pub use output::{Output, OutputCovariance, Unit, position_in_file, positions_in_file};
pub use pivoted_cholesky::pivoted_cholesky;
pub use predict::Prediction;
pub use read_out::{GIVE_COMMANDED, are_read_out, positions_are_read_out};
pub use readings::{
    MeasuredPoint, ball_bar_set_up, carrier, measured_home_mm, positioning_lines,
    predicted_reading_um,
};
pub use same_machine::{OtherMachine, check_same_machine};
pub use sensitivities::{Rows, Sensitivities};
pub use volume::places::{GridAxis, Places};
pub use volume::statistics::{Figures, Sizes};
pub use volume::{Drawn, Figure, Volume, VolumeSettings};
