//! The volumetric error of a calibrated machine, with its covariance.
//!
//! The error is that of [`Machine::volumetric_error_mm`]: the tool point relative to the workpiece,
//! in workpiece coordinates. To first order it changes with the errors of every axis of both
//! branches by their error motions at the tool point, and with the component errors at the measured
//! positions by the weights of the interpolation:
//!
//! ```text
//! dv = W⁻¹ (Σ_tool twist(p) - Σ_workpiece twist(p))      cov(v) = J cov(results) Jᵀ
//! ```
//!
//! Location errors that the frame defines away are certain; nothing is known of axes that were not
//! measured.

use nalgebra::{Isometry3, Matrix3, Matrix3xX, Point3, Vector3};
use trueaxis_kinematics::{Branch, GeometricErrors, LocationComponent, Machine};

use crate::propagate::axis_twist::{ROTATION, SHIFT, TILT, TRANSLATION, axis_twist};
use crate::result::calibration::{AxisResult, Calibration};
use crate::result::output::OutputCovariance;

/// How far the tool is from where it should be relative to the workpiece.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumetricError {
    /// Commanded positions of all axes of the machine, mm or rad.
    pub positions: Vec<f64>,
    /// The error in workpiece coordinates (those of the reference frame if no axis moves the
    /// workpiece), mm.
    pub error_mm: Vector3<f64>,
    /// Its covariance, mm²; `None` if the calibration was made without
    /// [`crate::Settings::covariance`].
    pub covariance_mm2: Option<Matrix3<f64>>,
}

impl Calibration {
    /// The volumetric error at commanded positions of all axes (mm or rad, in the order of
    /// [`Machine::axes`]) of the tool point that is at `tool_home_mm` in the reference frame at
    /// home. `machine` is that of the campaign.
    ///
    /// For a machine with one branch this is the error of a point that the branch carries: seen
    /// from the reference frame if the branch carries the tool, from the workpiece otherwise.
    ///
    /// # Panics
    /// If `positions` are fewer than the axes of `machine`.
    pub fn volumetric_error_at(
        &self,
        machine: &Machine,
        positions: &[f64],
        tool_home_mm: Point3<f64>,
    ) -> VolumetricError {
        let machine = self.with_reference_points(machine);
        let covariance_mm2 = self.covariance.as_ref().map(|covariance| {
            let influences = self.influences(&machine, positions, tool_home_mm, covariance);
            propagate(&influences, covariance)
        });
        VolumetricError {
            positions: positions.to_vec(),
            error_mm: machine.volumetric_error_mm(self, positions, tool_home_mm),
            covariance_mm2,
        }
    }

    /// The volumetric error at the corners of the volume that the axes were measured in, and in
    /// its centre (last); axes that were not measured stand at home.
    ///
    /// Arguments are those of [`Calibration::volumetric_error_at`]. There are 2ⁿ corners for n
    /// measured axes.
    pub fn volumetric_errors(
        &self,
        machine: &Machine,
        tool_home_mm: Point3<f64>,
    ) -> Vec<VolumetricError> {
        let ranges = self.axes.iter().filter_map(|axis| {
            let (first, last) = (axis.nodes.first()?, axis.nodes.last()?);
            Some((axis.axis, [first.position, last.position]))
        });
        let mut corners = vec![vec![0.0; machine.axes().len()]];
        let mut centre = corners[0].clone();
        for (axis, range) in ranges {
            centre[axis] = 0.5 * (range[0] + range[1]);
            let at = |corner: &Vec<f64>, end: f64| {
                let mut corner = corner.clone();
                corner[axis] = end;
                corner
            };
            corners = corners
                .iter()
                .flat_map(|corner| range.map(|end| at(corner, end)))
                .collect();
        }
        corners
            .iter()
            .chain([&centre])
            .map(|positions| self.volumetric_error_at(machine, positions, tool_home_mm))
            .collect()
    }

    /// The machine with the reference points that the component errors are given for.
    fn with_reference_points(&self, machine: &Machine) -> Machine {
        machine.with_axes(|index, axis| {
            match self.axes.iter().find(|result| result.axis == index) {
                Some(result) => axis.with_reference(result.reference_point_mm),
                None => axis,
            }
        })
    }

    /// What the volumetric error changes by, for each result that it depends on: its place among
    /// the outputs and mm per unit of it.
    fn influences(
        &self,
        machine: &Machine,
        positions: &[f64],
        tool_home_mm: Point3<f64>,
        covariance: &OutputCovariance,
    ) -> Vec<(usize, Vector3<f64>)> {
        let [tool, workpiece] = [Branch::Tool, Branch::Workpiece].map(|b| machine.branch(b));
        let tool_point = machine.chain_motion(self, tool, positions) * tool_home_mm;
        let from_bed = machine.chain_motion(self, workpiece, positions).rotation;
        let from_bed = from_bed.inverse().to_rotation_matrix().into_inner();
        let mut all = Vec::new();
        for (chain, sign) in [(tool, 1.0), (workpiece, -1.0)] {
            let mut base = Isometry3::identity();
            for &index in chain {
                let axis = &machine.axes()[index];
                let (location, error) =
                    (self.location(index), self.motion(index, positions[index]));
                if let Some(k) = self.axes.iter().position(|result| result.axis == index) {
                    let twist = axis_twist(axis, positions[index], &location, &error);
                    let effect = from_bed * twist.seen_from(&base).at(tool_point) * sign;
                    all.extend(self.influences_of(machine, k, positions[index], &effect));
                }
                base *= axis.motion(positions[index], &location, &error);
            }
        }
        let in_file_units = |(i, per_unit): (usize, Vector3<f64>)| {
            (i, per_unit * covariance.outputs[i].unit().size())
        };
        all.into_iter().map(in_file_units).collect()
    }

    /// The same for the results of axis `k` in mm and rad; `effect` has a column for each error of
    /// the axis ([`axis_twist`]).
    fn influences_of(
        &self,
        machine: &Machine,
        k: usize,
        position: f64,
        effect: &Matrix3xX<f64>,
    ) -> Vec<(usize, Vector3<f64>)> {
        let axis = &self.axes[k];
        let components =
            |axes: &[AxisResult]| -> usize { axes.iter().map(|axis| 6 * axis.nodes.len()).sum() };
        let locations = self.axes[..k].iter().map(|axis| axis.location_errors.len());
        let first = components(&self.axes[..k]);
        let first_location = components(&self.axes) + locations.sum::<usize>();
        let column = |i: usize| effect.column(i).into_owned();
        let mut all = Vec::new();
        for (node, weight) in axis.weights_at(position) {
            for c in 0..3 {
                let place = first + 6 * node + c;
                all.push((place, column(TRANSLATION + c) * weight));
                all.push((place + 3, column(ROTATION + c) * weight));
            }
        }
        let geometry = &machine.axes()[axis.axis];
        let (direction, principal) = (geometry.direction(), geometry.principal());
        for (i, location) in axis.location_errors.iter().enumerate() {
            let influence = match location.component {
                LocationComponent::Offset(c) => column(SHIFT + c),
                // A tilt is across the axis: the part that has no name follows from the others.
                LocationComponent::Tilt(c) => {
                    column(TILT + c)
                        - column(TILT + principal) * (direction[c] / direction[principal])
                }
            };
            all.push((first_location + i, influence));
        }
        all
    }
}

/// `J C Jᵀ` with the non-zero columns of J.
fn propagate(influences: &[(usize, Vector3<f64>)], covariance: &OutputCovariance) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for (i, a) in influences {
        let through: Vector3<f64> = influences
            .iter()
            .map(|(j, b)| b * covariance.matrix[(*i, *j)])
            .sum();
        sum += a * through.transpose();
    }
    (sum + sum.transpose()) * 0.5
}
