//! The joint covariance of the quantities from which an axis' results follow.
//!
//! These quantities are the axis' parameters `y` and, for each node, the mean pose error `m_k = mean A_i x_i` of its
//! poses ([`crate::identify::identify_axes::Sensitivity`]). The component errors are `E_k = m_k - Λ_k y`; what
//! other axes need of this one is linear in `y` and `m`, too. With the noise of [`trueaxis_poses`] every linear
//! function `f` of these quantities is
//!
//! ```text
//! f = f(ξ) - F s     cov(f, g) = cov(f(ξ), g(ξ)) + F Σ Gᵀ
//! ```
//!
//! The first part, *own*, is what remains if the shared sources are known; it is zero between axes and
//! between the `m` of different nodes.

use std::ops::Range;

use nalgebra::{DMatrix, Matrix6, Matrix6xX, Vector6};
use trueaxis_poses::PoseNoise;

use crate::identify::axis_data::AxisData;
use crate::identify::context::Context;
use crate::identify::gauge::LeastSquaresGauge;
use crate::identify::identify_axes::{Identified, Sensitivity};
use crate::in_order;

/// Linear functions of an axis' parameters and mean pose errors.
pub(crate) struct AxisForm {
    /// Coefficients of `y`, one row for each function.
    pub(crate) parameters: DMatrix<f64>,
    /// The mean pose errors that enter.
    pub(crate) poses: Vec<PosePart>,
}

/// `weight m_node`, added to six consecutive functions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PosePart {
    /// First of the functions.
    pub(crate) row: usize,
    pub(crate) node: usize,
    pub(crate) weight: f64,
}

impl AxisForm {
    /// The component errors of some nodes: six functions each.
    pub(crate) fn component_errors(gauge: &LeastSquaresGauge, nodes: Range<usize>) -> Self {
        let mut parameters = DMatrix::zeros(6 * nodes.len(), gauge.parameters());
        let mut poses = Vec::new();
        for (i, node) in nodes.enumerate() {
            let effect = &gauge.node_effects[node];
            parameters.rows_mut(6 * i, 6).copy_from(&-effect);
            poses.push(PosePart {
                row: 6 * i,
                node,
                weight: 1.0,
            });
        }
        Self { parameters, poses }
    }
}

/// Covariance of the parameters and mean pose errors of one axis.
pub(crate) struct AxisNoise<'a> {
    noise: &'a PoseNoise,
    axis: &'a AxisData,
    gauge: &'a LeastSquaresGauge,
    sensitivity: &'a Sensitivity,
    /// Own part of `cov(y)`.
    parameters: DMatrix<f64>,
    /// Coefficients of `-s` in `y`.
    parameters_shared: DMatrix<f64>,
}

/// The noise of one node's mean pose error `m`.
struct NodeNoise {
    own: Matrix6<f64>,
    /// Own part of `cov(m, y)`.
    cross: Matrix6xX<f64>,
    shared: Matrix6xX<f64>,
}

impl<'a> AxisNoise<'a> {
    /// The noise of axis `k` of the data.
    pub(crate) fn new(
        noise: &'a PoseNoise,
        context: &Context<'a>,
        identified: &'a Identified,
        k: usize,
    ) -> Self {
        let axis = &context.data[k];
        let (gauge, sensitivity) = (&identified.gauges[k], &identified.sensitivities[k]);
        let (width, sources) = (gauge.parameters(), noise.width());
        let zero = || DMatrix::zeros(width, width + sources);
        let both = in_order::sum(axis.poses.len(), zero, |sum, i| {
            let (y, pose) = (&sensitivity.parameters[i], axis.poses[i].index);
            let mut own = sum.columns_mut(0, width);
            own.gemm(1.0, &(y * noise.own[pose]), &y.transpose(), 1.0);
            let mut shared = sum.columns_mut(width, sources);
            shared.gemm(1.0, y, &noise.coupling(pose), 1.0);
        });
        Self {
            noise,
            axis,
            gauge,
            sensitivity,
            parameters: both.columns(0, width).into_owned(),
            parameters_shared: both.columns(width, sources).into_owned(),
        }
    }

    fn node(&self, node: usize) -> NodeNoise {
        let mut sum = NodeNoise {
            own: Matrix6::zeros(),
            cross: Matrix6xX::zeros(self.gauge.parameters()),
            shared: Matrix6xX::zeros(self.noise.width()),
        };
        let poses = &self.axis.poses_of[node];
        for &i in poses {
            let pose = self.axis.poses[i].index;
            let from_pose = self.sensitivity.poses[i] * self.axis.poses[i].weight;
            let with_noise = from_pose * self.noise.own[pose];
            sum.own += with_noise * from_pose.transpose();
            let parameters = self.sensitivity.parameters[i].row_iter();
            let parameters = parameters.map(|row| row.transpose());
            add_product(&mut sum.cross, &with_noise, parameters);
            let couplings = self.noise.coupling(pose);
            let couplings = couplings.column_iter().map(|column| column.into_owned());
            add_product(&mut sum.shared, &from_pose, couplings);
        }
        sum
    }

    /// For the mean pose errors of some nodes (six rows each): the own part `B` of the covariance of each, the own
    /// part of that with other functions of the axis, and the coefficients of the shared sources `s`.
    pub(crate) fn mean_errors(
        &self,
        nodes: Range<usize>,
        functions: &AxisForm,
    ) -> (Vec<Matrix6<f64>>, DMatrix<f64>, DMatrix<f64>) {
        let (rows, parameters) = (6 * nodes.len(), &functions.parameters);
        let mut own = Vec::with_capacity(nodes.len());
        let mut with_functions = DMatrix::zeros(rows, parameters.nrows());
        let mut shared = DMatrix::zeros(rows, self.noise.width());
        for (i, k) in nodes.enumerate() {
            let node = self.node(k);
            let mut with = with_functions.fixed_rows_mut::<6>(6 * i);
            for (mut column, function) in with.column_iter_mut().zip(parameters.row_iter()) {
                for (cross, coefficient) in node.cross.column_iter().zip(&function) {
                    column += cross * *coefficient;
                }
            }
            for pose in functions.poses.iter().filter(|pose| pose.node == k) {
                let mut block = with.fixed_columns_mut::<6>(pose.row);
                block += node.own * pose.weight;
            }
            let mut shared = shared.fixed_rows_mut::<6>(6 * i);
            shared -= &node.shared;
            own.push(node.own);
        }
        (own, with_functions, shared)
    }

    /// Own part of the covariance of functions.
    pub(crate) fn own(&self, form: &AxisForm) -> DMatrix<f64> {
        let parameters = form.parameters.transpose();
        let mut covariance = &form.parameters * &self.parameters * &parameters;
        for pose in &form.poses {
            let node = self.node(pose.node);
            let mut rows = covariance.rows_mut(pose.row, 6);
            rows += &node.cross * &parameters * pose.weight;
            for second in form.poses.iter().filter(|other| other.node == pose.node) {
                let mut block = rows.fixed_columns_mut::<6>(second.row);
                block += node.own * (pose.weight * second.weight);
            }
        }
        for pose in &form.poses {
            let mut columns = covariance.columns_mut(pose.row, 6);
            columns += &form.parameters * (self.node(pose.node).cross.transpose() * pose.weight);
        }
        covariance
    }

    /// Coefficients of the shared sources `s` in the functions.
    pub(crate) fn shared(&self, form: &AxisForm) -> DMatrix<f64> {
        let mut coefficients = -(&form.parameters * &self.parameters_shared);
        for pose in &form.poses {
            let mut rows = coefficients.rows_mut(pose.row, 6);
            rows -= self.node(pose.node).shared * pose.weight;
        }
        coefficients
    }
}

/// Adds the product of a factor and columns, column by column in fixed sizes: the general product of such small
/// matrices is mostly overhead.
fn add_product(
    sum: &mut Matrix6xX<f64>,
    factor: &Matrix6<f64>,
    columns: impl Iterator<Item = Vector6<f64>>,
) {
    for (mut sum, column) in sum.column_iter_mut().zip(columns) {
        sum += factor * column;
    }
}
