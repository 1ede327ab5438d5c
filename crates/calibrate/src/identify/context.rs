//! The input of the identification, and the errors of the machine as identified so far.

use nalgebra::{Isometry3, Point3};
use trueaxis_campaign::Campaign;
use trueaxis_kinematics::{Axis, GeometricErrors, LocationError, Machine, MotionError};
use trueaxis_poses::Poses;

use crate::identify::axis_data::AxisData;
use crate::identify::state::State;

/// The machine and the measured poses.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) campaign: &'a Campaign,
    pub(crate) machine: &'a Machine,
    pub(crate) poses: &'a Poses,
    /// The measured poses (datum from home), which a replay moves.
    pub(crate) measured: &'a [Isometry3<f64>],
    /// The poses by the axis under test.
    pub(crate) data: &'a [AxisData],
}

impl<'a> Context<'a> {
    /// The axis of `data[k]`.
    pub(crate) fn axis(&self, k: usize) -> &'a Axis {
        &self.machine.axes()[self.data[k].axis]
    }

    /// The index of an axis of the machine in the data, if it was measured.
    pub(crate) fn place_of(&self, axis: usize) -> Option<usize> {
        self.data.iter().position(|data| data.axis == axis)
    }

    pub(crate) fn run_names(&self, k: usize) -> Vec<String> {
        let runs = self.data[k].runs.iter();
        runs.map(|run| self.campaign.runs[run.run].name.clone())
            .collect()
    }

    /// The measured axes from the bed outwards.
    pub(crate) fn outwards(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.data.len()).collect();
        order.sort_by_key(|&k| self.machine.chain(self.data[k].axis).len());
        order
    }

    /// The errors of the whole machine as identified so far; none for axes that were not measured.
    pub(crate) fn errors<'b>(&'b self, state: &'b State) -> ModelErrors<'b> {
        ModelErrors {
            context: self,
            state,
        }
    }
}

/// See [`Context::errors`].
#[derive(Clone, Copy)]
pub(crate) struct ModelErrors<'a> {
    context: &'a Context<'a>,
    state: &'a State,
}

impl ModelErrors<'_> {
    /// The motion of some axes, in the order of a chain.
    pub(crate) fn chain_motion(&self, chain: &[usize], positions: &[f64]) -> Isometry3<f64> {
        self.context.machine.chain_motion(self, chain, positions)
    }

    /// The targets of run `r` of axis `data[k]` at home in the reference frame, mm.
    pub(crate) fn targets_mm(&self, k: usize, r: usize) -> Vec<Point3<f64>> {
        let run = &self.context.data[k].runs[r];
        let on_stage =
            self.chain_motion(&run.inner, &run.positions) * self.state.axes[k].placements[r];
        let home = |(place, p): (usize, &Point3<f64>)| {
            let inside = self.chain_motion(&run.inside[place], &run.positions);
            inside.inverse() * (on_stage * p)
        };
        let shape_mm = self.context.poses.bodies[run.body].home_mm.iter();
        shape_mm.enumerate().map(home).collect()
    }
}

impl GeometricErrors for ModelErrors<'_> {
    fn location(&self, axis: usize) -> LocationError {
        let place = self.context.place_of(axis);
        place.map_or_else(LocationError::default, |k| self.state.axes[k].location)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let Some(k) = self.context.place_of(axis) else {
            return MotionError::default();
        };
        let curve = &self.state.axes[k].curve;
        let weights = self.context.data[k].weights_at(position).into_iter();
        let sum = weights.map(|(node, weight)| curve[node].to_vector() * weight);
        MotionError::from_vector(&sum.sum())
    }
}
