//! Variances of the component errors of all nodes of an axis.
//!
//! With the parts of [`crate::axis_noise`], `E = m - Λ̂ y` has the own covariance
//!
//! ```text
//! cov(E) = Λ̂ cov(y) Λ̂ᵀ - cov(m, y) Λ̂ᵀ - Λ̂ cov(y, m) + cov(m)
//! ```
//!
//! and the coefficients `Λ̂ F_y - F_m` of the shared sources. First what each record gives to the mean `m` of
//! its node is found, records side by side, then the whole, nodes side by side.

use std::ops::Range;

use nalgebra::{DMatrix, Matrix6xX, Vector6};
use trueaxis_leastsquares::lane_products::{LaneMatrix, SharedMatrix, add_product};
use trueaxis_leastsquares::{LANES, Lanes, in_widest_registers, lanes_only, side_by_side, zeros};

use crate::axis_noise::AxisNoise;
use crate::in_order;
use crate::point_noise::ChunkErrors;
use crate::record_chunks::Chunk;
use crate::variance::Variance;

/// What component errors owe to all sources through a base that moves: its part of their own variance,
/// and the coefficients of the shared sources.
pub(crate) struct ThroughBase {
    pub(crate) own: Vector6<f64>,
    pub(crate) shared: Matrix6xX<f64>,
}

/// Component errors of a node.
const COMPONENTS: usize = 6;

/// Numbers that a record gives before its coefficients: the variance of each component of `m`, and the
/// diagonal of `cov(m, y) Λ̂ᵀ`.
const VARIANCES: usize = 2 * COMPONENTS;

/// Nodes that one thread takes at a time: many enough that few chunks have records of several pieces, which are
/// then worked on several times.
const NODES: usize = 16 * LANES;

/// What the records of some chunks give to the means of their nodes.
#[derive(Default)]
struct RecordParts {
    /// The chunks, ascending.
    chunks: Vec<usize>,
    /// Lane after lane of each: variances and the coefficients `F_m`, columns contiguous.
    numbers: Vec<f64>,
    /// Numbers of a record.
    length: usize,
}

impl AxisNoise<'_> {
    /// The variances of the six component errors of every node; `shared` is `Σ`.
    pub(crate) fn node_variances(
        &self,
        shared: &DMatrix<f64>,
        through_base: impl Fn(usize) -> Option<ThroughBase> + Sync,
    ) -> Vec<[Variance; COMPONENTS]> {
        let places = self.places_of_records();
        let nodes = self.sensitivity.node_effects.len();
        let of_piece = |memory: &mut Memory, piece: usize| {
            let piece = NODES * piece..nodes.min(NODES * (piece + 1));
            let Memory { parts, records, .. } = &mut *memory;
            parts.fill(self, &places, piece.clone(), records);
            let mut variances = Vec::with_capacity(piece.len());
            for first in piece.clone().step_by(LANES) {
                let eight = first..piece.end.min(first + LANES);
                let Memory { parts, nodes, .. } = &mut *memory;
                nodes.take(self, (parts, &places), eight.clone());
                for (lane, node) in eight.clone().enumerate() {
                    if let Some(through_base) = through_base(node) {
                        nodes.add_through_base(lane, &through_base);
                    }
                }
                in_widest_registers(
                    #[inline(always)]
                    || nodes.fill_variances(self, shared),
                );
                nodes.append_variances(eight.len(), &mut variances);
            }
            variances
        };
        let variances = in_order::map_with(nodes.div_ceil(NODES), 1, of_piece);
        variances.into_iter().flatten().collect()
    }

    /// Chunk and lane of each record.
    fn places_of_records(&self) -> Vec<(usize, usize)> {
        let mut places = vec![(0, 0); self.axis.records.len()];
        for (c, chunk) in self.axis.chunks.iter().enumerate() {
            for (lane, record) in chunk.records() {
                places[record] = (c, lane);
            }
        }
        places
    }
}

/// Memory for a piece.
#[derive(Default)]
struct Memory {
    parts: RecordParts,
    records: RecordMemory,
    nodes: NodeMemory,
}

impl RecordParts {
    /// Takes the chunks that have records of some nodes.
    fn fill(
        &mut self,
        axis: &AxisNoise<'_>,
        places: &[(usize, usize)],
        nodes: Range<usize>,
        memory: &mut RecordMemory,
    ) {
        self.length = VARIANCES + COMPONENTS * axis.shared_sources;
        self.chunks.clear();
        let records = nodes.flat_map(|node| axis.records.of(node));
        self.chunks.extend(records.map(|&record| places[record].0));
        self.chunks.sort_unstable();
        self.chunks.dedup();
        self.numbers.clear();
        for &chunk in &self.chunks {
            memory.append_parts(axis, &axis.axis.chunks[chunk], &mut self.numbers);
        }
    }

    /// Those of a record, which must be in one of the chunks.
    fn of(&self, (chunk, lane): (usize, usize)) -> &[f64] {
        let chunk = self.chunks.partition_point(|&c| c < chunk);
        &self.numbers[(chunk * LANES + lane) * self.length..][..self.length]
    }
}

/// Memory for the records of a chunk.
#[derive(Default)]
struct RecordMemory {
    errors: ChunkErrors,
    /// The record's share in `P`, its `Y` and the node's `Λ̂`, columns contiguous.
    from_points: Vec<Lanes>,
    parameters: Vec<Lanes>,
    effect: Vec<Lanes>,
    /// `P D`, `P D Yᵀ`, `P Z`.
    with_noise: Vec<Lanes>,
    cross: Vec<Lanes>,
    coefficients: Vec<Lanes>,
    variances: Vec<Lanes>,
}

impl RecordMemory {
    fn append_parts(&mut self, axis: &AxisNoise<'_>, chunk: &Chunk, parts: &mut Vec<f64>) {
        axis.noise.of_chunk(chunk, &mut self.errors);
        in_widest_registers(
            #[inline(always)]
            || self.fill(axis, chunk),
        );
        let numbers = || self.variances.iter().chain(&self.coefficients);
        let of_lane = |lane: usize| numbers().map(move |x| x.0[lane]);
        parts.extend((0..LANES).flat_map(of_lane));
    }

    #[inline(always)]
    fn fill(&mut self, axis: &AxisNoise<'_>, chunk: &Chunk) {
        let (points, width) = (chunk.coordinates(), axis.sensitivity.width());
        let node = |i: usize| axis.axis.records[i].node;
        chunk.take(
            COMPONENTS * points,
            |i| axis.fits[i].from_points.as_slice(),
            &mut self.from_points,
        );
        let mut weights = Lanes::ZERO;
        for (lane, i) in chunk.records() {
            weights.0[lane] = 1.0 / axis.records.of(node(i)).len() as f64;
        }
        for x in &mut self.from_points {
            *x = *x * weights;
        }
        let of_record = |i: usize| axis.sensitivity.parameters[i].as_slice();
        chunk.take(width * points, of_record, &mut self.parameters);
        let of_node = |i: usize| axis.sensitivity.node_effects[node(i)].as_slice();
        chunk.take(COMPONENTS * width, of_node, &mut self.effect);

        let from_points = LaneMatrix::by_columns(&self.from_points, [COMPONENTS, points]);
        zeros(&mut self.with_noise, COMPONENTS * points);
        add_product(&mut self.with_noise, from_points, self.errors.own());
        let with_noise = LaneMatrix::by_rows(&self.with_noise, [COMPONENTS, points]);
        zeros(&mut self.cross, COMPONENTS * width);
        let parameters = LaneMatrix::by_columns(&self.parameters, [width, points]);
        add_product(&mut self.cross, with_noise, parameters.transposed());
        let cross = LaneMatrix::by_rows(&self.cross, [COMPONENTS, width]);
        let effect = LaneMatrix::by_columns(&self.effect, [COMPONENTS, width]);
        self.variances.clear();
        for c in 0..COMPONENTS {
            self.variances.push(row_product(with_noise, from_points, c));
        }
        for c in 0..COMPONENTS {
            self.variances.push(row_product(cross, effect, c));
        }
        // Columns contiguous, as they are written: the rows of the transpose.
        zeros(&mut self.coefficients, COMPONENTS * axis.shared_sources);
        let coupling = self.errors.coupling().transposed();
        add_product(&mut self.coefficients, coupling, from_points.transposed());
    }
}

/// Memory for eight nodes.
#[derive(Default)]
struct NodeMemory {
    /// Sums over the records: variances and coefficients `F_m`, columns contiguous.
    parts: Vec<Lanes>,
    /// `Λ̂`, columns contiguous.
    effect: Vec<Lanes>,
    /// What comes through a moving base: variances and coefficients, columns contiguous.
    through_base: Vec<Lanes>,
    /// `Λ̂ cov(y)`, the coefficients `F` of the component errors, and `F Σ`.
    with_noise: Vec<Lanes>,
    coefficients: Vec<Lanes>,
    times_shared: Vec<Lanes>,
    /// Of the components: own variance, what comes through the stations, what cancels in the own.
    own: Vec<Lanes>,
    through: Vec<Lanes>,
    uncancelled: Vec<Lanes>,
}

impl NodeMemory {
    fn take(
        &mut self,
        axis: &AxisNoise<'_>,
        (parts, places): (&RecordParts, &[(usize, usize)]),
        nodes: Range<usize>,
    ) {
        let effects = &axis.sensitivity.node_effects;
        let mut slices: [&[f64]; LANES] = [&[]; LANES];
        zeros(&mut self.parts, parts.length);
        zeros(
            &mut self.through_base,
            COMPONENTS * (1 + axis.shared_sources),
        );
        for (lane, node) in nodes.enumerate() {
            slices[lane] = effects[node].as_slice();
            for &record in axis.records.of(node) {
                for (sum, x) in self.parts.iter_mut().zip(parts.of(places[record])) {
                    lanes_only();
                    sum.0[lane] += x;
                }
            }
        }
        let length = COMPONENTS * axis.sensitivity.width();
        side_by_side(slices, length, &mut self.effect);
    }

    fn add_through_base(&mut self, lane: usize, through_base: &ThroughBase) {
        let numbers = through_base.own.iter().chain(&through_base.shared);
        for (place, x) in self.through_base.iter_mut().zip(numbers) {
            place.0[lane] = *x;
        }
    }

    #[inline(always)]
    fn fill_variances(&mut self, axis: &AxisNoise<'_>, shared: &DMatrix<f64>) {
        let (width, sources) = (axis.sensitivity.width(), axis.shared_sources);
        let effect = LaneMatrix::by_columns(&self.effect, [COMPONENTS, width]);
        let parameters = axis.parameters.as_slice();
        let parameters = SharedMatrix::by_columns(parameters, [width; 2]);
        zeros(&mut self.with_noise, COMPONENTS * width);
        add_product(&mut self.with_noise, effect, parameters);
        let with_noise = LaneMatrix::by_rows(&self.with_noise, [COMPONENTS, width]);

        let (of_mean, of_base) = (&self.parts[VARIANCES..], &self.through_base[COMPONENTS..]);
        zeros(&mut self.coefficients, COMPONENTS * sources);
        let parameters = axis.parameters_shared.as_slice();
        let parameters = SharedMatrix::by_columns(parameters, [width, sources]);
        add_product(&mut self.coefficients, effect, parameters);
        for (c, row) in self
            .coefficients
            .chunks_exact_mut(sources.max(1))
            .enumerate()
        {
            for (k, x) in row.iter_mut().enumerate() {
                lanes_only();
                let place = k * COMPONENTS + c;
                *x = (*x - of_mean[place]) + of_base[place];
            }
        }
        let coefficients = LaneMatrix::by_rows(&self.coefficients, [COMPONENTS, sources]);
        zeros(&mut self.times_shared, COMPONENTS * sources);
        let shared = SharedMatrix::by_columns(shared.as_slice(), [sources; 2]);
        add_product(&mut self.times_shared, coefficients, shared);
        let times_shared = LaneMatrix::by_rows(&self.times_shared, [COMPONENTS, sources]);

        for numbers in [&mut self.own, &mut self.through, &mut self.uncancelled] {
            numbers.clear();
        }
        for c in 0..COMPONENTS {
            let (of_mean, mixed) = (self.parts[c], self.parts[COMPONENTS + c]);
            let uncancelled = row_product(with_noise, effect, c) + of_mean;
            self.uncancelled.push(uncancelled);
            self.own
                .push(uncancelled - (mixed + mixed) + self.through_base[c]);
            self.through
                .push(row_product(times_shared, coefficients, c));
        }
    }

    /// Appends those of so many nodes.
    fn append_variances(&self, nodes: usize, variances: &mut Vec<[Variance; COMPONENTS]>) {
        let variance = |lane: usize, c: usize| Variance {
            own: self.own[c].0[lane],
            through: self.through[c].0[lane],
            uncancelled: self.uncancelled[c].0[lane],
        };
        let of_lane = |lane: usize| std::array::from_fn(|c| variance(lane, c));
        variances.extend((0..nodes).map(of_lane));
    }
}

/// Row `c` of `A` times row `c` of `B`.
#[inline(always)]
fn row_product(a: LaneMatrix<'_>, b: LaneMatrix<'_>, c: usize) -> Lanes {
    let mut sum = Lanes::ZERO;
    for k in 0..a.columns() {
        lanes_only();
        sum = a.at(c, k).mul_add(b.at(c, k), sum);
    }
    sum
}
