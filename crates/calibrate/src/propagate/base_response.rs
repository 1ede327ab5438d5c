//! What a small motion of the base of an axis does to its results.
//!
//! The results of an axis are found from poses in the frame of its base, which the axes outside it
//! carry. If these have the error motion `ξ` during a run, the poses of the run are displaced by
//! `-ξ` as seen from there. A motion that all runs have in common is location error and place of
//! the targets; component errors answer only to the difference between runs.

use nalgebra::{Matrix6, MatrixXx6};

use crate::identify::context::Context;
use crate::identify::identify_axes::Identified;
use crate::identify::twist_map::twist_map;
use crate::in_order;
use crate::propagate::axis_noise::AxisForm;

/// Response of an axis' parameters and mean pose errors to a twist of all poses of a run, given as
/// by [`crate::propagate::twist::Twist::rows`].
pub(crate) struct BaseResponse {
    /// Of the parameters `y`, for each run.
    parameters: Vec<MatrixXx6<f64>>,
    /// Of the pose error of each record, with its run; empty for a single run, whose base stands still.
    pub(crate) records: Vec<(usize, Matrix6<f64>)>,
    /// Of each node's mean pose error, for the runs that measured it.
    poses: Vec<Vec<(usize, Matrix6<f64>)>>,
}

impl BaseResponse {
    /// Of axis `k` of the data.
    pub(crate) fn new(context: &Context<'_>, identified: &Identified, k: usize) -> Self {
        let axis = &context.data[k];
        let (gauge, sensitivity) = (&identified.gauges[k], &identified.sensitivities[k]);
        let ref_from_datum = identified.state.ref_from_datum;
        let datum_from_ref = ref_from_datum.rotation.inverse().to_rotation_matrix();
        let datum_from_ref = datum_from_ref.matrix();
        let mut new = Self {
            parameters: vec![MatrixXx6::zeros(gauge.parameters()); axis.runs.len()],
            records: Vec::new(),
            poses: vec![Vec::new(); axis.nodes.len()],
        };
        let answers = in_order::map(axis.records.len(), |i| {
            let record = &axis.records[i];
            // The pivot moves by v + ρ × p.
            let pivot = ref_from_datum * context.poses.observations[record.pose].pivot_mm;
            let lever = -datum_from_ref * pivot.coords.cross_matrix();
            let moved = twist_map(datum_from_ref, &lever);
            (
                &sensitivity.parameters[i] * moved,
                sensitivity.poses[i] * moved,
            )
        });
        for (record, (parameters, pose)) in axis.records.iter().zip(answers) {
            new.parameters[record.run] += parameters;
            let weight = 1.0 / axis.nodes[record.node].records.len() as f64;
            new.poses[record.node].push((record.run, pose * weight));
            if axis.runs.len() > 1 {
                new.records.push((record.run, pose));
            }
        }
        new
    }

    /// Response of functions to a twist of all poses of a run: one row for each function.
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
