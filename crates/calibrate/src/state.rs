//! The machine model while it is identified.

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_kinematics::{GeometricErrors, LocationError, MotionError};

use crate::axis_data::AxisData;

/// The current values of everything that the points determine.
#[derive(Debug, Clone)]
pub(crate) struct State {
    /// Brings measured points into the reference frame.
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
    /// For each run the targets at home in the reference frame, in the order of
    /// [`crate::axis_data::RunData::targets`].
    pub(crate) targets_mm: Vec<Vec<Point3<f64>>>,
}

/// The errors of the whole machine: what is identified so far, nothing for other axes.
#[derive(Clone, Copy)]
pub(crate) struct ModelErrors<'a> {
    pub(crate) data: &'a [AxisData],
    pub(crate) state: &'a State,
}

impl GeometricErrors for ModelErrors<'_> {
    fn location(&self, axis: usize) -> LocationError {
        self.data
            .iter()
            .position(|data| data.axis == axis)
            .map_or_else(LocationError::default, |k| self.state.axes[k].location)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let Some(k) = self.data.iter().position(|data| data.axis == axis) else {
            return MotionError::default();
        };
        let curve = &self.state.axes[k].curve;
        let mut sum = (Vector3::zeros(), Vector3::zeros());
        for (node, weight) in self.data[k].weights_at(position) {
            sum.0 += curve[node].translation_mm * weight;
            sum.1 += curve[node].rotation_rad * weight;
        }
        MotionError::new(sum.0, sum.1)
    }
}
