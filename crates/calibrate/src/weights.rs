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
use trueaxis_leastsquares::lane_products::{Element, LaneMatrix, SharedMatrix, View, add_product};
use trueaxis_leastsquares::{Lanes, in_widest_registers, lanes_only, zeros};

use crate::axis_data::{AxisData, RunData};
use crate::chunk_sums::chunk_sums;
use crate::in_order::{self, CHUNKS};
use crate::point_noise::ChunkErrors;
use crate::record_chunks::Chunk;
use crate::records::{Context, around};

/// Covariances of all records of an axis in datum coordinates, mm². They serve as weights, so the
/// nominal geometry is good enough.
pub(crate) fn weights(context: &Context<'_>, data: &AxisData) -> Vec<DMatrix<f64>> {
    let shared = context.measured.noise.shared();
    let shapes: Vec<ShapeNoise> = (0..data.runs.len())
        .map(|run| ShapeNoise::new(context, data, run, shared.nrows()))
        .collect();
    let of_chunks = in_order::map_with(data.chunks.len(), CHUNKS, |memory: &mut Memory, c| {
        let chunk = &data.chunks[c];
        memory.take(context, data, &shapes, chunk);
        in_widest_registers(
            #[inline(always)]
            || memory.fill(chunk.coordinates(), &shared),
        );
        let of_record = |(lane, i)| (i, memory.in_lane(chunk.coordinates(), lane));
        chunk.records().map(of_record).collect::<Vec<_>>()
    });
    let mut weights = vec![DMatrix::zeros(0, 0); data.records.len()];
    for (i, weight) in of_chunks.into_iter().flatten() {
        weights[i] = weight;
    }
    weights
}

/// A rotation for each lane, `[row][column]`.
type Rotations = [[Lanes; 3]; 3];

/// Memory for the records of a chunk.
#[derive(Default)]
struct Memory {
    errors: ChunkErrors,
    /// `1 / n`.
    per_records: Lanes,
    /// `Qᵀ`.
    datum_from_stage: Rotations,
    /// `Π`, `W` and `mean Π Q Z` of the runs, and the first two seen from the datum.
    projection: Vec<Lanes>,
    own: Vec<Lanes>,
    coupling: Vec<Lanes>,
    turned_projection: Vec<Lanes>,
    turned_own: Vec<Lanes>,
    half_turned: Vec<Lanes>,
    /// `D G`, `T`, `T Σ`, and `C`.
    cross: Vec<Lanes>,
    through: Vec<Lanes>,
    times_shared: Vec<Lanes>,
    covariance: Vec<Lanes>,
}

impl Memory {
    fn take(
        &mut self,
        context: &Context<'_>,
        data: &AxisData,
        shapes: &[ShapeNoise],
        chunk: &Chunk,
    ) {
        context.measured.noise.of_chunk(chunk, &mut self.errors);
        self.per_records = Lanes::ZERO;
        self.datum_from_stage = Rotations::default();
        for (lane, i) in chunk.records() {
            self.per_records.0[lane] = 1.0 / shapes[data.records[i].run].records;
            let turn = stage_from_datum(context, data, i);
            put(&turn.transpose(), lane, &mut self.datum_from_stage);
        }
        let (size, shape) = (chunk.coordinates(), |i: usize| &shapes[data.records[i].run]);
        let squared = size * size;
        chunk.take(
            squared,
            |i| shape(i).projection.as_slice(),
            &mut self.projection,
        );
        chunk.take(squared, |i| shape(i).own.as_slice(), &mut self.own);
        let length = self.errors.coupling().columns() * size;
        chunk.take(length, |i| shape(i).coupling.as_slice(), &mut self.coupling);
    }

    /// Makes `C` of so many coordinates.
    #[inline(always)]
    fn fill(&mut self, size: usize, shared: &DMatrix<f64>) {
        let turn = &self.datum_from_stage;
        for (matrix, turned) in [
            (&self.projection, &mut self.turned_projection),
            (&self.own, &mut self.turned_own),
        ] {
            turn_rows(
                LaneMatrix::by_columns(matrix, [size; 2]),
                turn,
                &mut self.half_turned,
            );
            let half_turned = LaneMatrix::by_rows(&self.half_turned, [size; 2]);
            turn_rows(half_turned.transposed(), turn, turned);
        }
        let (d, z) = (self.errors.own(), self.errors.coupling());
        let sources = z.columns();
        zeros(&mut self.cross, size * size);
        let projection = LaneMatrix::by_columns(&self.turned_projection, [size; 2]);
        add_product(&mut self.cross, d, projection);
        let cross = LaneMatrix::by_rows(&self.cross, [size; 2]);

        let coupling = LaneMatrix::by_columns(&self.coupling, [size, sources]);
        turn_rows(coupling, turn, &mut self.through);
        for (i, row) in self.through.chunks_exact_mut(sources.max(1)).enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                lanes_only();
                *x = z.at(i, j) - *x;
            }
        }
        let through = LaneMatrix::by_rows(&self.through, [size, sources]);
        zeros(&mut self.times_shared, size * sources);
        let shared = SharedMatrix::by_columns(shared.as_slice(), [sources; 2]);
        add_product(&mut self.times_shared, through, shared);
        let times_shared = LaneMatrix::by_rows(&self.times_shared, [size, sources]);

        self.covariance.clear();
        for i in 0..size {
            for j in 0..size {
                let mixed = (cross.at(i, j) + cross.at(j, i)) * self.per_records;
                let own = d.at(i, j) + self.turned_own[i * size + j];
                self.covariance.push(own - mixed);
            }
        }
        add_product(&mut self.covariance, times_shared, through.transposed());
    }

    /// `C` of the record in a lane, symmetric to the last bit, as the identification asks.
    fn in_lane(&self, size: usize, lane: usize) -> DMatrix<f64> {
        DMatrix::from_fn(size, size, |i, j| {
            let [this, mirrored] = [i * size + j, j * size + i];
            0.5 * (self.covariance[this].0[lane] + self.covariance[mirrored].0[lane])
        })
    }
}

/// The noise of the shape of the targets of a run; zero for a run of a single record, which is all the
/// shape there is, and for targets on a line, which the identification refuses.
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
    fn new(context: &Context<'_>, data: &AxisData, run: usize, sources: usize) -> Self {
        let records = data.runs[run].records as f64;
        let size = 3 * data.runs[run].targets.len();
        let sizes = [[size, size], [size, sources]];
        let is_repeated = data.runs[run].records > 1;
        let projection = is_repeated.then(|| shape_projection(context, &data.runs[run], data));
        let Some(projection) = projection.flatten() else {
            let [own, coupling] = sizes.map(|[rows, columns]| DMatrix::zeros(rows, columns));
            return Self {
                projection: DMatrix::zeros(size, size),
                records,
                own,
                coupling,
            };
        };
        let add = |memory: &mut ShapeMemory, chunk: &Chunk, sums: &mut [Vec<Lanes>; 2]| {
            if memory.take(context, data, run, chunk) {
                in_widest_registers(
                    #[inline(always)]
                    || memory.add(&projection, sums),
                );
            }
        };
        let [own, coupling] = chunk_sums(&data.chunks, sizes, add);
        Self {
            projection,
            records,
            own: own / (records * records),
            coupling: coupling / records,
        }
    }
}

/// Memory for what a chunk adds to the noise of a shape.
#[derive(Default)]
struct ShapeMemory {
    errors: ChunkErrors,
    /// `Q`; zero in lanes that have no record of the run.
    stage_from_datum: Rotations,
    /// `Π Q`, and `Π Q D`.
    to_shape: Vec<Lanes>,
    with_noise: Vec<Lanes>,
}

impl ShapeMemory {
    /// Whether the chunk has records of the run.
    fn take(&mut self, context: &Context<'_>, data: &AxisData, run: usize, chunk: &Chunk) -> bool {
        let of_run = |&(_, i): &(usize, usize)| data.records[i].run == run;
        if !chunk.records().any(|record| of_run(&record)) {
            return false;
        }
        context.measured.noise.of_chunk(chunk, &mut self.errors);
        self.stage_from_datum = Rotations::default();
        for (lane, i) in chunk.records().filter(of_run) {
            let turn = stage_from_datum(context, data, i);
            put(&turn, lane, &mut self.stage_from_datum);
        }
        true
    }

    /// Adds `Π Q D Qᵀ Πᵀ` and `Π Q Z`.
    #[inline(always)]
    fn add(&mut self, projection: &DMatrix<f64>, [own, coupling]: &mut [Vec<Lanes>; 2]) {
        let size = projection.nrows();
        let turn = &self.stage_from_datum;
        // Columns of Π Q contiguous: the rows of Qᵀ Πᵀ.
        let datum_from_stage: Rotations =
            std::array::from_fn(|i| std::array::from_fn(|j| turn[j][i]));
        let projection = SharedMatrix::by_rows(projection.as_slice(), [size; 2]);
        turn_rows(projection, &datum_from_stage, &mut self.to_shape);
        let to_shape = LaneMatrix::by_columns(&self.to_shape, [size; 2]);
        zeros(&mut self.with_noise, size * size);
        add_product(&mut self.with_noise, to_shape, self.errors.own());
        let with_noise = LaneMatrix::by_rows(&self.with_noise, [size; 2]);
        add_product(own, with_noise, to_shape.transposed());
        add_product(coupling, to_shape, self.errors.coupling());
    }
}

/// The same rotation of every three rows of a matrix; rows of the result contiguous.
#[inline(always)]
fn turn_rows<E: Element>(matrix: View<'_, E>, turn: &Rotations, turned: &mut Vec<Lanes>) {
    turned.clear();
    for first in (0..matrix.rows()).step_by(3) {
        for [x, y, z] in turn {
            for column in 0..matrix.columns() {
                lanes_only();
                let of = |axis: usize| matrix.at(first + axis, column);
                turned.push(x.mul_add(of(0), y.mul_add(of(1), *z * of(2))));
            }
        }
    }
}

fn put(rotation: &Matrix3<f64>, lane: usize, rotations: &mut Rotations) {
    for (i, row) in rotations.iter_mut().enumerate() {
        for (j, x) in row.iter_mut().enumerate() {
            x.0[lane] = rotation[(i, j)];
        }
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
