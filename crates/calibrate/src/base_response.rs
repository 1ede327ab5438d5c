//! What a small motion of the base of an axis does to its results.
//!
//! The results of an axis are found from points in the frame of its base, which the axes outside it
//! carry. If these have the error motion `ξ` during a run, the points of the run are displaced by
//! `-ξ` as seen from there. A motion that all runs have in common is location error and position of
//! the targets; component errors answer only to the difference between runs.

use nalgebra::{Isometry3, Matrix6, MatrixXx6};

use crate::axis_data::{AxisData, points_of};
use crate::axis_noise::AxisForm;
use crate::in_order;
use crate::measured::Measured;
use crate::records::RecordFit;
use crate::sensitivity::Sensitivity;
use crate::twist::cross_matrix;

/// Response of an axis' parameters and mean pose errors to a twist of all points of a run, given as
/// by [`crate::twist::Twist::rows`].
pub(crate) struct BaseResponse {
    /// Of the parameters `y`, for each run.
    parameters: Vec<MatrixXx6<f64>>,
    /// Of each node's mean pose error, for the runs that measured it.
    poses: Vec<Vec<(usize, Matrix6<f64>)>>,
}

impl BaseResponse {
    pub(crate) fn new(
        measured: &Measured,
        axis: &AxisData,
        fits: &[RecordFit],
        sensitivity: &Sensitivity,
        ref_from_datum: &Isometry3<f64>,
    ) -> Self {
        let datum_from_ref = ref_from_datum.rotation.inverse().to_rotation_matrix();
        let mut new = Self {
            parameters: vec![MatrixXx6::zeros(sensitivity.width()); axis.runs.len()],
            poses: vec![Vec::new(); axis.nodes.len()],
        };
        let answers = in_order::map(axis.records.len(), |i| {
            let record = &axis.records[i];
            // Displacements v + ρ × p of the points in the datum.
            let mut displacements = MatrixXx6::zeros(3 * record.targets.len());
            for (place, (_, point)) in points_of(measured, &measured.points_mm, record).enumerate()
            {
                let lever = cross_matrix((ref_from_datum * point).coords);
                let mut rows = displacements.fixed_rows_mut::<3>(3 * place);
                rows.fixed_columns_mut::<3>(0)
                    .copy_from(datum_from_ref.matrix());
                rows.fixed_columns_mut::<3>(3)
                    .copy_from(&(-datum_from_ref.matrix() * lever));
            }
            let weight = 1.0 / axis.nodes[record.node].records as f64;
            let pose: Matrix6<f64> = &fits[i].from_points * &displacements * weight;
            (&sensitivity.parameters[i] * displacements, pose)
        });
        for (record, (parameters, pose)) in axis.records.iter().zip(answers) {
            new.parameters[record.run] += parameters;
            new.poses[record.node].push((record.run, pose));
        }
        new
    }

    /// Response of functions to a twist of all points of a run: one row for each function.
    pub(crate) fn of(&self, form: &AxisForm, run: usize) -> MatrixXx6<f64> {
        let mut response = &form.parameters * &self.parameters[run];
        for part in &form.poses {
            for (_, pose) in self.poses[part.node].iter().filter(|(r, _)| *r == run) {
                let mut rows = response.fixed_rows_mut::<6>(part.row);
                rows += pose * part.weight;
            }
        }
        response
    }
}
