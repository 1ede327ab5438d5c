//! The component errors of every pose of an axis, relative to the current model.
//!
//! With all axes outside the one under test (`B`) and inside it (`C`) taken from the model, and the body at home as
//! in its run (`H`), the measured pose `P` is
//!
//! ```text
//! B⁻¹ P = T(q) C H        T: commanded motion, location errors, component errors
//! ```
//!
//! What the model of the axis leaves is a small motion, whose translation at the reference point and rotation are
//! added to the component errors. As the prediction is exact, repeating this leaves no second-order error (Newton's
//! method on the pose; paper Eqs. 2 and 20).

use nalgebra::{Isometry3, Matrix6, Point3, UnitQuaternion, Vector6};
use trueaxis_kinematics::MotionError;
use trueaxis_poses::twist_map;

use crate::identify::axis_data::RunData;
use crate::identify::context::Context;
use crate::identify::state::State;
use crate::in_order;

/// The effect of the other axes, which stand still, on the body of a run.
struct Surroundings {
    /// `B⁻¹` after the motion into the reference frame.
    base_from_datum: Isometry3<f64>,
    /// `C H`.
    stage_from_body: Isometry3<f64>,
}

/// A pose seen from the base of its axis.
struct Seen {
    base_from_datum: Isometry3<f64>,
    /// `B⁻¹ P (C H)⁻¹ T⁻¹`: what the model of the axis leaves.
    left: Isometry3<f64>,
    /// The reference point of δ by the model, mm.
    reference_mm: Point3<f64>,
    /// The component errors of the model.
    current: MotionError,
}

impl Context<'_> {
    /// Component errors of every pose of the axis `data[k]`, before the gauge: δ (mm) and ε (rad).
    pub(crate) fn pose_errors(&self, state: &State, k: usize) -> Vec<Vector6<f64>> {
        let surroundings = self.surroundings(state, k);
        in_order::map(self.data[k].poses.len(), |pose| {
            let seen = self.seen(state, k, &surroundings, pose);
            let correction = MotionError::new(
                seen.left * seen.reference_mm - seen.reference_mm,
                seen.left.rotation.scaled_axis(),
            );
            composed(&correction, &seen.current).to_vector()
        })
    }

    /// How the pose errors follow from the errors of the measured poses ([`trueaxis_poses`]).
    pub(crate) fn error_maps(&self, state: &State, k: usize) -> Vec<Matrix6<f64>> {
        let surroundings = self.surroundings(state, k);
        in_order::map(self.data[k].poses.len(), |pose| {
            let seen = self.seen(state, k, &surroundings, pose);
            let observation = &self.poses.observations[self.data[k].poses[pose].index];
            let turn = seen.base_from_datum.rotation.to_rotation_matrix();
            let arm_mm = seen.reference_mm - seen.base_from_datum * observation.pivot_mm;
            twist_map(turn.matrix(), &(-arm_mm.cross_matrix() * turn.matrix()))
        })
    }

    /// The surroundings of each run of the axis `data[k]`.
    fn surroundings(&self, state: &State, k: usize) -> Vec<Surroundings> {
        let errors = self.errors(state);
        let of_run = |(run, home_from_body): (&RunData, &Isometry3<f64>)| {
            let base = errors.chain_motion(&run.outer, &run.positions);
            let inside = errors.chain_motion(&run.inner, &run.positions);
            Surroundings {
                base_from_datum: base.inverse() * state.ref_from_datum,
                stage_from_body: inside * home_from_body,
            }
        };
        let runs = self.data[k].runs.iter().zip(&state.axes[k].placements);
        runs.map(of_run).collect()
    }

    fn seen(&self, state: &State, k: usize, surroundings: &[Surroundings], pose: usize) -> Seen {
        let (own, values) = (&self.data[k], &state.axes[k]);
        let pose = &own.poses[pose];
        let axis = self.axis(k);
        let current = values.curve[pose.node];
        let position = own.nodes[pose.node].position;
        let motion = axis.motion(position, &values.location, &current);
        let around = &surroundings[pose.run];
        Seen {
            base_from_datum: around.base_from_datum,
            left: around.base_from_datum
                * self.measured[pose.index]
                * (motion * around.stage_from_body).inverse(),
            reference_mm: motion * axis.reference_at_home_mm(&values.location),
            current,
        }
    }
}

/// A correction after an error: `exp(ε₂) exp(ε₁)` and the sum of the translations.
fn composed(correction: &MotionError, current: &MotionError) -> MotionError {
    let turn = |e: &MotionError| UnitQuaternion::from_scaled_axis(e.rotation_rad);
    MotionError::new(
        correction.translation_mm + current.translation_mm,
        (turn(correction) * turn(current)).scaled_axis(),
    )
}
