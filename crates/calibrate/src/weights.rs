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

use std::ops::SubAssign;

use nalgebra::{DMatrix, Matrix3, Vector3};
use trueaxis_identify::{equations, nine};
use trueaxis_kinematics::{Ideal, LocationError};

use crate::axis_data::{AxisData, RunData};
use crate::in_order;
use crate::matrix_products::{add_product, add_product_transposed};
use crate::records::{Context, around, rotated, rotated_columns};

/// Covariances of all records of an axis in datum coordinates, mm². They serve as weights, so the
/// nominal geometry is good enough.
pub(crate) fn weights(context: &Context<'_>, data: &AxisData) -> Vec<DMatrix<f64>> {
    let noise = &context.measured.noise;
    let shared = noise.shared();
    let shapes: Vec<Option<ShapeNoise>> = (0..data.runs.len())
        .map(|run| ShapeNoise::new(context, data, run))
        .collect();
    in_order::map_with(data.records.len(), |errors, i| {
        let record = &data.records[i];
        let (d, z) = noise.of_record(record, errors);
        let mut covariance = d.clone();
        let mut through = z.clone();
        if let Some(shape) = &shapes[record.run] {
            let back = stage_from_datum(context, data, i).transpose();
            covariance += rotated(&shape.own, &back);
            let mut cross = DMatrix::zeros(d.nrows(), d.ncols());
            add_product(&mut cross, d, &rotated(&shape.projection, &back));
            cross /= -shape.records;
            covariance += cross.transpose();
            covariance += cross;
            for first in (0..z.nrows()).step_by(3) {
                let turned = back * shape.coupling.fixed_rows::<3>(first);
                through.fixed_rows_mut::<3>(first).sub_assign(turned);
            }
        }
        let mut with_noise = DMatrix::zeros(through.nrows(), through.ncols());
        add_product(&mut with_noise, &through, &shared);
        add_product_transposed(&mut covariance, &with_noise, &through);
        // Symmetric to the last bit, as the identification asks.
        (&covariance + covariance.transpose()) * 0.5
    })
}

/// The noise of the shape of the targets of a run.
struct ShapeNoise {
    /// `Π`.
    projection: DMatrix<f64>,
    /// Number of records `n`.
    records: f64,
    /// `W`.
    own: DMatrix<f64>,
    /// `mean Π Q Z`.
    coupling: DMatrix<f64>,
}

impl ShapeNoise {
    /// `None` for a run of a single record, which is all the shape there is.
    fn new(context: &Context<'_>, data: &AxisData, run: usize) -> Option<Self> {
        let noise = &context.measured.noise;
        let records: Vec<usize> = (0..data.records.len())
            .filter(|&i| data.records[i].run == run)
            .collect();
        let projection = shape_projection(context, &data.runs[run], data)?;
        if records.len() < 2 {
            return None;
        }
        let count = records.len() as f64;
        let size = projection.nrows();
        let sources = noise.shared().nrows();
        let zero = || (DMatrix::zeros(size, size), DMatrix::zeros(size, sources));
        let add = |(own, coupling): &mut (DMatrix<f64>, DMatrix<f64>), errors: &mut _, n: usize| {
            let i = records[n];
            let turn = stage_from_datum(context, data, i);
            let to_shape = rotated_columns(&projection, &turn);
            let (d, z) = noise.of_record(&data.records[i], errors);
            let mut with_noise = DMatrix::zeros(size, size);
            add_product(&mut with_noise, &to_shape, d);
            add_product_transposed(own, &with_noise, &to_shape);
            add_product(coupling, &to_shape, z);
        };
        let (own, coupling) = in_order::sum(records.len(), zero, add, |whole, part| {
            whole.0 += part.0;
            whole.1 += part.1;
        });
        Some(Self {
            projection,
            records: count,
            own: own / (count * count),
            coupling: coupling / count,
        })
    }
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
