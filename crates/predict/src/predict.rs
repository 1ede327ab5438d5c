//! The error of the tool against the workpiece at any place, with its covariance.
//!
//! The error itself follows from the exact motions ([`Machine::tool_error`]). To first order it changes with the
//! errors of every axis of both branches by their error motions at the tool point, with the component errors at the
//! steps by the weights of the interpolation, and with what the interpolation leaves:
//!
//! ```text
//! dδ, dε = W⁻¹ (Σ_tool twist - Σ_workpiece twist)      cov = J cov(results) Jᵀ + K diag(u_interpolation²) Kᵀ
//! ```
//!
//! Location errors that the frame defines away are certain.

use nalgebra::{Isometry3, Matrix6, Matrix6xX, Point3, Vector6};
use rayon::prelude::*;
use trueaxis_kinematics::axis_twist::{ROTATION, SHIFT, TILT, TRANSLATION, axis_twist};
use trueaxis_kinematics::{
    Branch, GeometricErrors, LocationComponent, Machine, MotionError, Twist,
};

use crate::calibrated_machine::{CalibratedAxis, CalibratedMachine};
use crate::curve::Sample;

/// The error of the tool against the workpiece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Displacement of the tool point (mm) and rotation of the tool (rad), actual against nominal, along the
    /// reference axes of the workpiece at home, which turn with it.
    pub error: MotionError,
    /// Its covariance in the order of [`MotionError::to_vector`], mm and rad; NaN if it is not known
    /// ([`CalibratedMachine::has_uncertainties`]).
    pub covariance: Matrix6<f64>,
    /// The part of it that comes from interpolation between the steps.
    pub of_interpolation: Matrix6<f64>,
    /// Whether an axis stands outside its steps (or was not measured): the errors of its nearest step are taken.
    pub extrapolated: bool,
}

impl Prediction {
    /// Standard uncertainties in the order of [`MotionError::to_vector`], mm and rad; NaN if they are not known.
    pub fn u(&self) -> Vector6<f64> {
        // Rounding may leave less than zero; what is not known stays so.
        self.covariance
            .diagonal()
            .map(|v| if v < 0.0 { 0.0 } else { v.sqrt() })
    }
}

impl CalibratedMachine {
    /// The error of the tool against the workpiece at commanded positions of all axes (mm or rad, in the order of
    /// [`Machine::axes`]) for the tool point that is at `tool_home_mm` in the reference frame at home.
    ///
    /// For a machine with one branch this is the error of a point that the branch carries: seen from the reference
    /// frame if the branch carries the tool, from the workpiece otherwise.
    ///
    /// # Panics
    /// If `positions` are fewer than the axes of the machine.
    pub fn predict(&self, positions: &[f64], tool_home_mm: Point3<f64>) -> Prediction {
        let mut functions = Vec::new();
        let mut of_interpolation = Matrix6::zeros();
        let mut extrapolated = false;
        for (axis, effect) in self.effects(positions, tool_home_mm) {
            let sample = axis.curve.at(positions[axis.axis]);
            extrapolated |= sample.beyond > 0.0;
            functions.extend(influences(&self.machine, axis, &sample, &effect));
            let u = axis.remainder.u(&sample);
            let of_components = effect.fixed_columns::<6>(TRANSLATION);
            of_interpolation += of_components
                * Matrix6::from_diagonal(&u.component_mul(&u))
                * of_components.transpose();
        }
        let mut covariance = self.factors.of_functions(&functions, &functions) + of_interpolation;
        if !self.has_uncertainties {
            covariance.fill(f64::NAN);
        }
        Prediction {
            error: self.machine.tool_error(self, positions, tool_home_mm),
            covariance: (covariance + covariance.transpose()) * 0.5,
            of_interpolation,
            extrapolated: extrapolated || self.axes.len() < self.machine.axes().len(),
        }
    }

    /// Whether each measured axis stands within its measured steps at positions of all axes (mm or rad, in the order of
    /// [`Machine::axes`]); outside, the errors of its nearest step are taken.
    ///
    /// # Panics
    /// If `positions` are fewer than the axes of the machine.
    pub fn is_within_steps(&self, positions: &[f64]) -> bool {
        let beyond = |axis: &CalibratedAxis| axis.curve.at(positions[axis.axis]).beyond > 0.0;
        !self.axes.iter().any(beyond)
    }

    /// [`CalibratedMachine::predict`] at many places, on all threads.
    pub fn predict_all(&self, places: &[(Vec<f64>, Point3<f64>)]) -> Vec<Prediction> {
        let places = places.par_iter();
        places.map(|(at, tool)| self.predict(at, *tool)).collect()
    }

    /// The point of the tool (or, without axes that move a tool, of the workpiece) whose displacement the component
    /// errors of its last axis give, mm: where a place on the tool is not asked for.
    pub fn reference_point_mm(&self) -> Point3<f64> {
        let [tool, workpiece] =
            [Branch::Tool, Branch::Workpiece].map(|branch| self.machine.branch(branch));
        let last = tool.last().or(workpiece.last());
        last.map_or_else(Point3::origin, |&axis| {
            self.machine.axes()[axis].reference_mm()
        })
    }

    /// For each measured axis of both branches what its errors do to tool point and tool: a column for each of
    /// [`axis_twist`].
    pub(crate) fn effects(
        &self,
        positions: &[f64],
        tool_home_mm: Point3<f64>,
    ) -> Vec<(&CalibratedAxis, Matrix6xX<f64>)> {
        let machine = &self.machine;
        let [tool, workpiece] =
            [Branch::Tool, Branch::Workpiece].map(|branch| machine.branch(branch));
        let tool_point = machine.chain_motion(self, tool, positions) * tool_home_mm;
        let from_bed = machine.chain_motion(self, workpiece, positions).rotation;
        let from_bed = from_bed.inverse().to_rotation_matrix().into_inner();
        let mut all = Vec::new();
        for (chain, sign) in [(tool, 1.0), (workpiece, -1.0)] {
            for (axis, twist) in self.twists(chain, positions) {
                let mut effect = Matrix6xX::zeros(twist.rotation.ncols());
                let displacement = from_bed * twist.at(tool_point) * sign;
                effect.fixed_rows_mut::<3>(0).copy_from(&displacement);
                let rotation = from_bed * &twist.rotation * sign;
                effect.fixed_rows_mut::<3>(3).copy_from(&rotation);
                all.push((axis, effect));
            }
        }
        all
    }

    /// For each measured axis of a chain the motion that its errors make of all outside it, seen from the bed: a
    /// column for each of [`axis_twist`].
    pub(crate) fn twists(
        &self,
        chain: &[usize],
        positions: &[f64],
    ) -> Vec<(&CalibratedAxis, Twist)> {
        let mut all = Vec::new();
        let mut base = Isometry3::identity();
        for &index in chain {
            let (geometry, position) = (&self.machine.axes()[index], positions[index]);
            let (location, error) = (self.location(index), self.motion(index, position));
            if let Some(axis) = self.axis(index) {
                let twist = axis_twist(geometry, position, &location, &error);
                all.push((axis, twist.seen_from(&base)));
            }
            base *= geometry.motion(position, &location, &error);
        }
        all
    }
}

/// What the results of an axis do to the error: their places, and mm and rad for mm or rad.
pub(crate) fn influences(
    machine: &Machine,
    axis: &CalibratedAxis,
    sample: &Sample,
    effect: &Matrix6xX<f64>,
) -> Vec<(usize, Vector6<f64>)> {
    let column = |i: usize| -> Vector6<f64> { effect.column(i).into_owned() };
    let mut all = Vec::new();
    for &(node, weight) in &sample.weights {
        let first = axis.first + 6 * node;
        all.extend((0..3).map(|c| (first + c, column(TRANSLATION + c) * weight)));
        all.extend((0..3).map(|c| (first + 3 + c, column(ROTATION + c) * weight)));
    }
    let geometry = &machine.axes()[axis.axis];
    let (direction, principal) = (geometry.direction(), geometry.principal());
    for (i, component) in axis.reported.iter().enumerate() {
        let influence = match *component {
            LocationComponent::Offset(c) => column(SHIFT + c),
            // A tilt is across the axis: the part that has no name follows from the others.
            LocationComponent::Tilt(c) => {
                column(TILT + c) - column(TILT + principal) * (direction[c] / direction[principal])
            }
        };
        all.push((axis.first_location + i, influence));
    }
    all
}
