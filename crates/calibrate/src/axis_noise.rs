//! The joint covariance of what an axis' results follow from.
//!
//! These are its parameters `y` and, for each node, the mean pose error `m_k = mean P_i dp_i` of its
//! records ([`crate::sensitivity`]): the component errors are `E_k = m_k - Λ̂_k y`, and what other
//! axes need of this one is linear in `y` and `m` as well. With `dp_i = ξ_i - Z_i s`
//! ([`crate::point_noise`]) every linear function `f` of them is
//!
//! ```text
//! f = f(ξ) - F s     cov(f, g) = cov(f(ξ), g(ξ)) + F Σ Gᵀ
//! ```
//!
//! The first part, *own*, is what remains if the stations are known; it is zero between axes and
//! between the `m` of different nodes. The second comes through the stations.

use nalgebra::{DMatrix, Matrix6, Matrix6xX};

use crate::axis_data::AxisData;
use crate::point_noise::PointNoise;
use crate::records::RecordFit;
use crate::sensitivity::Sensitivity;

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
    pub(crate) fn component_errors(
        sensitivity: &Sensitivity,
        nodes: std::ops::Range<usize>,
    ) -> Self {
        let mut parameters = DMatrix::zeros(6 * nodes.len(), sensitivity.width());
        let mut poses = Vec::new();
        for (i, node) in nodes.enumerate() {
            let effect = &sensitivity.node_effects[node];
            parameters.rows_mut(6 * i, 6).copy_from(&-effect);
            poses.push(PosePart {
                row: 6 * i,
                node,
                weight: 1.0,
            });
        }
        Self { parameters, poses }
    }

    fn count(&self) -> usize {
        self.parameters.nrows()
    }
}

/// Covariance of the parameters and mean pose errors of one axis.
pub(crate) struct AxisNoise {
    /// Own part of `cov(y)`.
    parameters: DMatrix<f64>,
    /// Coefficients of `-s` in `y`.
    parameters_shared: DMatrix<f64>,
    nodes: Vec<NodeNoise>,
}

/// The same of one node's mean pose error `m`.
struct NodeNoise {
    own: Matrix6<f64>,
    /// Own part of `cov(m, y)`.
    cross: Matrix6xX<f64>,
    shared: Matrix6xX<f64>,
}

impl AxisNoise {
    pub(crate) fn new(
        noise: &PointNoise<'_>,
        shared_sources: usize,
        axis: &AxisData,
        fits: &[RecordFit],
        sensitivity: &Sensitivity,
    ) -> Self {
        let width = sensitivity.width();
        let empty = || NodeNoise {
            own: Matrix6::zeros(),
            cross: Matrix6xX::zeros(width),
            shared: Matrix6xX::zeros(shared_sources),
        };
        let mut new = Self {
            parameters: DMatrix::zeros(width, width),
            parameters_shared: DMatrix::zeros(width, shared_sources),
            nodes: axis.nodes.iter().map(|_| empty()).collect(),
        };
        for (i, record) in axis.records.iter().enumerate() {
            let (d, z) = noise.of_record(record);
            let from_points = &fits[i].from_points;
            let parameters = &sensitivity.parameters[i];
            let weight = 1.0 / axis.nodes[record.node].records as f64;
            let pose_noise = from_points * &d * weight;
            new.parameters += parameters * &d * parameters.transpose();
            new.parameters_shared += parameters * &z;
            let node = &mut new.nodes[record.node];
            node.own += &pose_noise * from_points.transpose() * weight;
            node.cross += pose_noise * parameters.transpose();
            node.shared += from_points * z * weight;
        }
        new
    }

    /// Own part of the covariance between functions `a` (rows) and `b` (columns).
    pub(crate) fn own(&self, a: &AxisForm, b: &AxisForm) -> DMatrix<f64> {
        let mut covariance = &a.parameters * &self.parameters * b.parameters.transpose();
        for pose in &a.poses {
            let mut rows = covariance.rows_mut(pose.row, 6);
            rows += &self.nodes[pose.node].cross * b.parameters.transpose() * pose.weight;
        }
        for pose in &b.poses {
            let cross = self.nodes[pose.node].cross.transpose() * pose.weight;
            let mut columns = covariance.columns_mut(pose.row, 6);
            columns += &a.parameters * cross;
        }
        for first in &a.poses {
            for second in b.poses.iter().filter(|other| other.node == first.node) {
                let mut block = covariance.fixed_view_mut::<6, 6>(first.row, second.row);
                block += self.nodes[first.node].own * (first.weight * second.weight);
            }
        }
        covariance
    }

    /// For each function the sum of the variances whose combination its own variance is: the size
    /// of the numbers that cancel in it.
    pub(crate) fn own_uncancelled(&self, form: &AxisForm) -> Vec<f64> {
        let from_parameters = &form.parameters * &self.parameters;
        let mut sums: Vec<f64> = (0..form.count())
            .map(|i| from_parameters.row(i).dot(&form.parameters.row(i)))
            .collect();
        for pose in &form.poses {
            for (c, sum) in sums[pose.row..pose.row + 6].iter_mut().enumerate() {
                *sum += self.nodes[pose.node].own[(c, c)] * pose.weight * pose.weight;
            }
        }
        sums
    }

    /// Coefficients of the shared sources `s` in the functions.
    pub(crate) fn shared(&self, form: &AxisForm) -> DMatrix<f64> {
        let mut coefficients = -(&form.parameters * &self.parameters_shared);
        for pose in &form.poses {
            let mut rows = coefficients.rows_mut(pose.row, 6);
            rows -= &self.nodes[pose.node].shared * pose.weight;
        }
        coefficients
    }
}
