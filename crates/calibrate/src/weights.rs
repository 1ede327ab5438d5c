//! The covariance with which the equations of a step are weighted.
//!
//! The shape of the targets on the stage is not known beforehand; it is the mean over the run of
//! what no rigid motion explains, `w = mean Π_i Q_i dp_i`. The equations of a step are about
//! `dp_i - Q_iᵀ w`, so theirs is the covariance of this difference:
//!
//! ```text
//! C_i = D_i - (D_i G_iᵀ + G_i D_i) / n + Q_iᵀ W Q_i + T_i Σ T_iᵀ
//! G = Qᵀ Π Q     W = Σ Π Q D Qᵀ Π / n²     T = Z - Qᵀ mean Π Q Z
//! ```
//!
//! Weighting with the covariance of the points alone would trust the shape as if it were exact, and
//! take what the stations' errors do to the shape for a rotation.

use nalgebra::{DMatrix, Matrix3, Vector3};
use trueaxis_identify::{equations, nine};
use trueaxis_kinematics::{Ideal, LocationError};

use crate::axis_data::{AxisData, RunData};
use crate::records::{Context, around, select_targets};

/// Covariances of all records of an axis in datum coordinates, mm². They serve as weights, so the
/// nominal geometry is good enough.
pub(crate) fn weights(context: &Context<'_>, data: &AxisData) -> Vec<DMatrix<f64>> {
    let noise = &context.measured.noise;
    let mut all: Vec<DMatrix<f64>> = data
        .records
        .iter()
        .map(|record| select_targets(&noise.total(record.group), record))
        .collect();
    let shared = noise.shared();
    for (r, run) in data.runs.iter().enumerate() {
        let records: Vec<usize> = (0..data.records.len())
            .filter(|&i| data.records[i].run == r)
            .collect();
        let count = records.len() as f64;
        let Some(projection) = shape_projection(context, run, data) else {
            continue;
        };
        if records.len() < 2 {
            continue;
        }
        let size = projection.nrows();
        let mut shape_noise = DMatrix::zeros(size, size);
        let mut shape_coupling = DMatrix::zeros(size, shared.nrows());
        let mut parts = Vec::new();
        for &i in &records {
            let record = &data.records[i];
            let turn = stage_from_datum(context, data, i);
            let to_shape = &projection * repeated(&turn, size);
            let (d, z) = noise.of_record(record);
            shape_noise += &to_shape * &d * to_shape.transpose() / (count * count);
            shape_coupling += &to_shape * &z / count;
            parts.push((i, turn, to_shape, d, z));
        }
        for (i, turn, to_shape, d, z) in parts {
            let back = repeated(&turn, size).transpose();
            let cross = &d * to_shape.transpose() * back.transpose() / count;
            let through = z - &back * &shape_coupling;
            let covariance =
                d + &back * &shape_noise * back.transpose() - &cross - cross.transpose()
                    + &through * &shared * through.transpose();
            // Symmetric to the last bit, as the identification asks.
            all[i] = (&covariance + covariance.transpose()) * 0.5;
        }
    }
    all
}

/// `Π`: what is left of displacements of the run's targets after an unweighted rigid fit.
fn shape_projection(context: &Context<'_>, run: &RunData, data: &AxisData) -> Option<DMatrix<f64>> {
    let positions = context.positions_of(&data.records[run.first_record]);
    let levers: Vec<Vector3<f64>> = run
        .targets
        .iter()
        .map(|&target| {
            let target = &context.campaign.targets[target];
            let (_, inner) = around(context.machine, target.carrier, data.axis);
            let inside = context.machine.chain_motion(&Ideal, inner, positions);
            (inside * target.home_mm).coords
        })
        .collect();
    let plain = nine(&levers).ok()?;
    let size = 3 * levers.len();
    Some(DMatrix::identity(size, size) - equations(&levers) * plain.matrix())
}

/// `Q`: rotation to the stage at home from the datum, nominal.
fn stage_from_datum(context: &Context<'_>, data: &AxisData, record: usize) -> Matrix3<f64> {
    let positions = context.positions_of(&data.records[record]);
    let axis = &context.machine.axes()[data.axis];
    let carrier = data.records[record]
        .targets
        .first()
        .map_or(data.axis, |&(target, _)| {
            context.campaign.targets[target].carrier
        });
    let (outer, _) = around(context.machine, carrier, data.axis);
    let base = context.machine.chain_motion(&Ideal, outer, positions);
    let motion = axis.commanded_motion(positions[data.axis], &LocationError::default());
    (base * motion)
        .rotation
        .inverse()
        .to_rotation_matrix()
        .into_inner()
}

/// The same rotation for every point.
fn repeated(turn: &Matrix3<f64>, size: usize) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(size, size);
    for i in 0..size / 3 {
        all.fixed_view_mut::<3, 3>(3 * i, 3 * i).copy_from(turn);
    }
    all
}
