//! The machine model during identification.

use nalgebra::Isometry3;
use trueaxis_kinematics::{LocationError, MotionError};

/// The current values of everything that the poses determine.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Brings measured poses into the reference frame.
    pub(crate) ref_from_datum: Isometry3<f64>,
    /// In the order of the axis data.
    pub(crate) axes: Vec<AxisState>,
}

/// The current values of one axis.
#[derive(Debug, Clone)]
pub(crate) struct AxisState {
    pub(crate) location: LocationError,
    /// Component errors at each node.
    pub(crate) curve: Vec<MotionError>,
    /// For each run the home of its body: reference frame from the body's own coordinates.
    pub(crate) placements: Vec<Isometry3<f64>>,
}
