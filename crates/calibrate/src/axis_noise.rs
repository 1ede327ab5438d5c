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
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product};
use trueaxis_leastsquares::{Lanes, zeros};

use crate::axis_data::AxisData;
use crate::chunk_sums::chunk_sums;
use crate::node_records::NodeRecords;
use crate::point_noise::{ChunkErrors, PointNoise};
use crate::record_chunks::Chunk;
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
    pub(crate) noise: &'a PointNoise<'a>,
    pub(crate) shared_sources: usize,
    pub(crate) axis: &'a AxisData,
    pub(crate) fits: &'a [RecordFit],
    pub(crate) sensitivity: &'a Sensitivity,
    pub(crate) records: NodeRecords,
    /// Own part of `cov(y)`.
    pub(crate) parameters: DMatrix<f64>,
    /// Coefficients of `-s` in `y`.
    pub(crate) parameters_shared: DMatrix<f64>,
}

/// The same of one node's mean pose error `m`.
struct NodeNoise {
    own: Matrix6<f64>,
    /// Own part of `cov(m, y)`.
    cross: Matrix6xX<f64>,
    shared: Matrix6xX<f64>,
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
        let sizes = [[width, width], [width, shared_sources]];
        let [parameters, parameters_shared] = chunk_sums(
            &axis.chunks,
            sizes,
            |memory: &mut ParameterMemory, chunk, sums| {
                memory.add(noise, sensitivity, chunk, sums);
            },
        );
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

    fn node(&self, node: usize) -> NodeNoise {
        let mut sum = NodeNoise {
            own: Matrix6::zeros(),
            cross: Matrix6xX::zeros(self.sensitivity.width()),
            shared: Matrix6xX::zeros(self.shared_sources),
        };
        let records = self.records.of(node);
        let weight = 1.0 / records.len() as f64;
        let mut errors = ChunkErrors::default();
        for &i in records {
            let record = &self.axis.records[i];
            let places: Vec<usize> = record.places().collect();
            let (d, z) = self.noise.of_group(record.group, &places, &mut errors);
            let from_points = &self.fits[i].from_points * weight;
            let with_noise = &from_points * d;
            sum.own += &with_noise * from_points.transpose();
            sum.cross += with_noise * self.sensitivity.parameters[i].transpose();
            sum.shared += from_points * z;
        }
        sum
    }

    /// Own part of the covariance between functions `a` (rows) and `b` (columns).
    pub(crate) fn own(&self, a: &AxisForm, b: &AxisForm) -> DMatrix<f64> {
        let mut covariance = &a.parameters * &self.parameters * b.parameters.transpose();
        for pose in &a.poses {
            let node = self.node(pose.node);
            let mut rows = covariance.rows_mut(pose.row, 6);
            rows += &node.cross * b.parameters.transpose() * pose.weight;
            for second in b.poses.iter().filter(|other| other.node == pose.node) {
                let mut block = covariance.fixed_view_mut::<6, 6>(pose.row, second.row);
                block += node.own * (pose.weight * second.weight);
            }
        }
        for pose in &b.poses {
            let cross = self.node(pose.node).cross.transpose() * pose.weight;
            let mut columns = covariance.columns_mut(pose.row, 6);
            columns += &a.parameters * cross;
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

/// Memory for what a chunk adds to the parameters.
#[derive(Default)]
struct ParameterMemory {
    errors: ChunkErrors,
    /// `Y` of each record, columns contiguous, and `Y D`.
    parameters: Vec<Lanes>,
    with_noise: Vec<Lanes>,
}

impl ParameterMemory {
    /// Adds `Y D Yᵀ` and `Y Z`.
    fn add(
        &mut self,
        noise: &PointNoise<'_>,
        sensitivity: &Sensitivity,
        chunk: &Chunk,
        [own, shared]: &mut [Vec<Lanes>; 2],
    ) {
        let Self {
            errors,
            parameters,
            with_noise,
        } = self;
        noise.of_chunk(chunk, errors);
        let sizes = [sensitivity.width(), chunk.coordinates()];
        let of_record = |i: usize| sensitivity.parameters[i].as_slice();
        chunk.take(sizes[0] * sizes[1], of_record, parameters);
        let parameters = LaneMatrix::by_columns(parameters, sizes);
        zeros(with_noise, sizes[0] * sizes[1]);
        add_product(with_noise, parameters, errors.own());
        let with_noise = LaneMatrix::by_rows(with_noise, sizes);
        add_product(own, with_noise, parameters.transposed());
        add_product(shared, parameters, errors.coupling());
    }
}
