//! The response of the results of an axis to a small motion of its base.
//!
//! The results of an axis are found from poses in the frame of its base, which the axes outside it carry. If these
//! have the error motion `b` during a run, the poses of the run are displaced by `-b` in that frame. A motion common
//! to all runs enters location errors and positions of the targets; component errors depend only on differences
//! between runs.

use nalgebra::{DMatrix, Matrix6, MatrixXx6};
use trueaxis_poses::twist_map;

use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;
use crate::in_order;
use crate::propagate::axis_noise::AxisForm;

/// Response of an axis' parameters and mean pose errors to a twist of all poses of a run, in the form of
/// [`trueaxis_kinematics::Twist::rows`].
pub(crate) struct BaseResponse<'a> {
    context: &'a Context<'a>,
    identified: &'a Identified,
    k: usize,
    /// Response of the parameters `y`, six columns for each run.
    parameters: DMatrix<f64>,
}

impl<'a> BaseResponse<'a> {
    /// The response of axis `k` of the data.
    pub(crate) fn new(context: &'a Context<'a>, identified: &'a Identified, k: usize) -> Self {
        let (axis, gauge) = (&context.data[k], &identified.gauges[k]);
        let mut new = Self {
            context,
            identified,
            k,
            parameters: DMatrix::zeros(0, 0),
        };
        let zero = || DMatrix::zeros(gauge.parameters(), 6 * axis.runs.len());
        new.parameters = in_order::sum(axis.poses.len(), zero, |sum, i| {
            let of_pose = &identified.sensitivities[k].parameters[i];
            let mut of_run = sum.columns_mut(6 * axis.poses[i].run, 6);
            of_run += of_pose * new.moved(i);
        });
        new
    }

    /// Effect of a twist of its run on a pose. The pivot moves by v + ρ × p.
    fn moved(&self, i: usize) -> Matrix6<f64> {
        let ref_from_datum = self.identified.state.ref_from_datum;
        let datum_from_ref = ref_from_datum.rotation.inverse().to_rotation_matrix();
        let pose = self.context.data[self.k].poses[i].index;
        let pivot = ref_from_datum * self.context.poses.observations[pose].pivot_mm;
        let lever = -datum_from_ref.matrix() * pivot.coords.cross_matrix();
        twist_map(datum_from_ref.matrix(), &lever)
    }

    pub(crate) fn of_pose(&self, i: usize) -> Matrix6<f64> {
        self.identified.sensitivities[self.k].poses[i] * self.moved(i)
    }

    /// Response of functions to a twist of all poses of a run: one row for each function.
    pub(crate) fn of(&self, form: &AxisForm, run: usize) -> MatrixXx6<f64> {
        let axis = &self.context.data[self.k];
        let mut response = &form.parameters * self.parameters.fixed_columns::<6>(6 * run);
        for part in &form.poses {
            let poses = &axis.poses_of[part.node];
            for &i in poses.iter().filter(|&&i| axis.poses[i].run == run) {
                let mut rows = response.fixed_rows_mut::<6>(part.row);
                rows += self.of_pose(i) * (part.weight * axis.poses[i].weight);
            }
        }
        response
    }
}
