//! The machine model while it is identified.

use nalgebra::{Isometry3, Point3, Vector3};
use trueaxis_kinematics::{GeometricErrors, LocationError, Machine, MotionError};
use trueaxis_poses::TargetBody;

use crate::identify::axis_data::AxisData;

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
    /// For each run where its body is at home: reference frame from the body's own coordinates.
    pub(crate) placements: Vec<Isometry3<f64>>,
}

/// The errors of the whole machine: what is identified so far, nothing for other axes.
#[derive(Clone, Copy)]
pub(crate) struct ModelErrors<'a> {
    pub(crate) data: &'a [AxisData],
    pub(crate) state: &'a State,
}

impl ModelErrors<'_> {
    /// The targets of run `r` of axis `data[k]` at home in the reference frame, mm.
    pub(crate) fn targets_mm(
        &self,
        machine: &Machine,
        bodies: &[TargetBody],
        (k, r): (usize, usize),
    ) -> Vec<Point3<f64>> {
        let (run, axis) = (&self.data[k].runs[r], self.data[k].axis);
        let (_, inner) = run.around(machine, axis);
        let on_stage =
            machine.chain_motion(self, inner, &run.positions) * self.state.axes[k].placements[r];
        let home = |(place, p): (usize, &Point3<f64>)| {
            let inner = run.inside(machine, axis, place);
            machine.chain_motion(self, inner, &run.positions).inverse() * (on_stage * p)
        };
        bodies[run.body]
            .home_mm
            .iter()
            .enumerate()
            .map(home)
            .collect()
    }
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
