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

use nalgebra::{DMatrix, Matrix6, Matrix6xX, Vector6};

use trueaxis_multilateration::GroupNoise;

use crate::axis_data::AxisData;
use crate::in_order;
use crate::matrix_products::{add_product, add_product_transposed};
use crate::node_records::NodeRecords;
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
}

/// Covariance of the parameters and mean pose errors of one axis. The parts of single nodes are
/// computed when they are asked for: together they would be larger than all else.
pub(crate) struct AxisNoise<'a> {
    noise: &'a PointNoise<'a>,
    shared_sources: usize,
    axis: &'a AxisData,
    fits: &'a [RecordFit],
    sensitivity: &'a Sensitivity,
    records: NodeRecords,
    /// Own part of `cov(y)`.
    parameters: DMatrix<f64>,
    /// Coefficients of `-s` in `y`.
    parameters_shared: DMatrix<f64>,
}

/// The same of one node's mean pose error `m`.
struct NodeNoise {
    own: Matrix6<f64>,
    /// Own part of `cov(m, y)`.
    cross: Matrix6xX<f64>,
    shared: Matrix6xX<f64>,
}

/// The noise of the six component errors of one node.
pub(crate) struct ComponentNoise {
    /// Own part of their covariance.
    pub(crate) own: Matrix6<f64>,
    /// For each the sum of the variances that cancel in its own.
    pub(crate) uncancelled: Vector6<f64>,
    /// Coefficients of the shared sources `s`.
    pub(crate) shared: Matrix6xX<f64>,
}

impl<'a> AxisNoise<'a> {
    pub(crate) fn new(
        noise: &'a PointNoise<'a>,
        shared_sources: usize,
        axis: &'a AxisData,
        fits: &'a [RecordFit],
        sensitivity: &'a Sensitivity,
    ) -> Self {
        let width = sensitivity.width();
        let zero = || {
            (
                DMatrix::zeros(width, width),
                DMatrix::zeros(width, shared_sources),
            )
        };
        let add = |(own, shared): &mut (DMatrix<f64>, DMatrix<f64>), errors: &mut _, i: usize| {
            let (d, z) = noise.of_record(&axis.records[i], errors);
            let parameters = &sensitivity.parameters[i];
            let mut with_noise = DMatrix::zeros(width, d.ncols());
            add_product(&mut with_noise, parameters, d);
            add_product_transposed(own, &with_noise, parameters);
            add_product(shared, parameters, z);
        };
        let records = axis.records.len();
        let (parameters, parameters_shared) = in_order::sum(records, zero, add, |whole, part| {
            whole.0 += part.0;
            whole.1 += part.1;
        });
        Self {
            noise,
            shared_sources,
            axis,
            fits,
            sensitivity,
            records: NodeRecords::new(axis),
            parameters,
            parameters_shared,
        }
    }

    fn node(&self, node: usize, errors: &mut GroupNoise) -> NodeNoise {
        let mut sum = NodeNoise {
            own: Matrix6::zeros(),
            cross: Matrix6xX::zeros(self.sensitivity.width()),
            shared: Matrix6xX::zeros(self.shared_sources),
        };
        let records = self.records.of(node);
        let weight = 1.0 / records.len() as f64;
        for &i in records {
            let (d, z) = self.noise.of_record(&self.axis.records[i], errors);
            let from_points = &self.fits[i].from_points * weight;
            let mut with_noise = Matrix6xX::zeros(d.ncols());
            add_product(&mut with_noise, &from_points, d);
            add_product_transposed(&mut sum.own, &with_noise, &from_points);
            add_product_transposed(&mut sum.cross, &with_noise, &self.sensitivity.parameters[i]);
            add_product(&mut sum.shared, &from_points, z);
        }
        sum
    }

    /// The noise of the component errors of a node, its base standing still; `errors` is memory to
    /// work in.
    pub(crate) fn component_errors(&self, node: usize, errors: &mut GroupNoise) -> ComponentNoise {
        let effect = &self.sensitivity.node_effects[node];
        let NodeNoise {
            own,
            cross,
            mut shared,
        } = self.node(node, errors);
        shared.neg_mut();
        add_product(&mut shared, effect, &self.parameters_shared);
        let mut with_noise = Matrix6xX::zeros(effect.ncols());
        add_product(&mut with_noise, effect, &self.parameters);
        let mut through = Matrix6::zeros();
        add_product_transposed(&mut through, &with_noise, effect);
        let mut mixed = Matrix6::zeros();
        add_product_transposed(&mut mixed, &cross, effect);
        ComponentNoise {
            uncancelled: through.diagonal() + own.diagonal(),
            own: through - mixed - mixed.transpose() + own,
            shared,
        }
    }

    /// Own part of the covariance between functions `a` (rows) and `b` (columns).
    pub(crate) fn own(&self, a: &AxisForm, b: &AxisForm) -> DMatrix<f64> {
        let mut errors = GroupNoise::default();
        let mut covariance = &a.parameters * &self.parameters * b.parameters.transpose();
        for pose in &a.poses {
            let node = self.node(pose.node, &mut errors);
            let mut rows = covariance.rows_mut(pose.row, 6);
            rows += &node.cross * b.parameters.transpose() * pose.weight;
            for second in b.poses.iter().filter(|other| other.node == pose.node) {
                let mut block = covariance.fixed_view_mut::<6, 6>(pose.row, second.row);
                block += node.own * (pose.weight * second.weight);
            }
        }
        for pose in &b.poses {
            let cross = self.node(pose.node, &mut errors).cross.transpose() * pose.weight;
            let mut columns = covariance.columns_mut(pose.row, 6);
            columns += &a.parameters * cross;
        }
        covariance
    }

    /// Coefficients of the shared sources `s` in the functions.
    pub(crate) fn shared(&self, form: &AxisForm) -> DMatrix<f64> {
        let mut errors = GroupNoise::default();
        let mut coefficients = -(&form.parameters * &self.parameters_shared);
        for pose in &form.poses {
            let mut rows = coefficients.rows_mut(pose.row, 6);
            rows -= self.node(pose.node, &mut errors).shared * pose.weight;
        }
        coefficients
    }
}
