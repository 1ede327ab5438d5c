//! The errors of measured points: a part of its own for each group and a part that all share.
//!
//! ```text
//! dp_i = ξ_i - Z_i s     cov(ξ_i) = D_i, independent between groups     cov(s) = Σ
//! ```
//!
//! For lengths the shared sources `s` are the errors of stations and dead paths (first) and of the
//! datum; `D_i` is the covariance of the points with all stations known. This form holds for the
//! whole noise and for the instrument's own part of it alone, so both are propagated alike.

use std::ops::Range;
use std::sync::Arc;

use faer::MatRef;
use nalgebra::DMatrix;
use trueaxis_leastsquares::lane_products::{LaneMatrix, add_product};
use trueaxis_leastsquares::{CovarianceLanes, LANES, Lanes, side_by_side, zeros};
use trueaxis_multilateration::{BlockNoise, Screened};

use crate::record_chunks::{Chunk, batch_of};

/// Covariance of the measured points, mm².
pub(crate) struct PointNoise<'a> {
    pub(crate) source: NoiseSource<'a>,
    /// Factor on all variances.
    pub(crate) variance_factor: f64,
    /// The groups that are worked on side by side ([`trueaxis_multilateration::batches_of_groups`]).
    pub(crate) batches: Arc<Vec<Range<usize>>>,
}

pub(crate) enum NoiseSource<'a> {
    /// From the adjustment of lengths.
    Adjusted(Arc<Screened>),
    /// The lengths' own noise alone.
    Lengths(Box<BlockNoise<'a>>),
    /// Independent groups with these covariances.
    Independent(Vec<DMatrix<f64>>),
}

/// `D` and `Z` of points that have the same places in the groups of a batch, rows one after the other, and
/// memory to make them. Lanes behind the last group have no meaning.
#[derive(Debug, Default)]
pub(crate) struct ChunkErrors {
    coordinates: usize,
    width: usize,
    own: Vec<Lanes>,
    coupling: Vec<Lanes>,
    factors: CovarianceLanes,
    /// Of all points of the groups, in units of the variance factor, whatever the source.
    of_groups: OfGroups,
}

/// `D` and `Z` of all points of the groups, rows one after the other.
#[derive(Debug, Default)]
struct OfGroups {
    own: Vec<Lanes>,
    coupling: Vec<Lanes>,
}

impl ChunkErrors {
    /// `D`.
    #[inline(always)]
    pub(crate) fn own(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.own, [self.coordinates; 2])
    }

    /// `Z`.
    #[inline(always)]
    pub(crate) fn coupling(&self) -> LaneMatrix<'_> {
        LaneMatrix::by_rows(&self.coupling, [self.coordinates, self.width])
    }

    /// `D` and `Z` of the record in a lane.
    pub(crate) fn in_lane(&self, lane: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let in_lane = |matrix: LaneMatrix<'_>| {
            DMatrix::from_fn(matrix.rows(), matrix.columns(), |i, j| {
                matrix.at(i, j).0[lane]
            })
        };
        (in_lane(self.own()), in_lane(self.coupling()))
    }

    /// Takes the points at these places from those of the groups.
    fn take(&mut self, places: &[usize], variance_factor: f64) {
        let of_groups = &self.of_groups;
        let size = of_groups.own.len().isqrt();
        (self.coordinates, self.width) = (
            3 * places.len(),
            of_groups.coupling.len().checked_div(size).unwrap_or(0),
        );
        let rows = || places.iter().flat_map(|place| 3 * place..3 * place + 3);
        self.own.clear();
        self.coupling.clear();
        let factor = Lanes::splat(variance_factor);
        for row in rows() {
            for column in rows() {
                self.own.push(of_groups.own[row * size + column] * factor);
            }
            let row = &of_groups.coupling[row * self.width..][..self.width];
            self.coupling.extend_from_slice(row);
        }
    }
}

impl PointNoise<'_> {
    /// `D` and `Z` of the points of a chunk, in the order of its targets.
    pub(crate) fn of_chunk(&self, chunk: &Chunk, errors: &mut ChunkErrors) {
        self.fill(&chunk.groups, &chunk.places, errors);
    }

    /// `D` and `Z` of the points at these places of the groups of a batch.
    fn fill(&self, groups: &Range<usize>, places: &[usize], errors: &mut ChunkErrors) {
        let ChunkErrors {
            factors, of_groups, ..
        } = errors;
        match &self.source {
            NoiseSource::Adjusted(screened) => {
                let blocks = (groups.start, groups.len());
                factors.fill(&screened.solution.covariance, blocks);
                let (factor, z) = (factors.inverse_factor(), factors.coupling());
                zeros(&mut of_groups.own, z.rows() * z.rows());
                add_product(&mut of_groups.own, factor, factor.transposed());
                of_groups.coupling.clear();
                for i in 0..z.rows() {
                    of_groups.coupling.extend_from_slice(z.row(i));
                }
            }
            NoiseSource::Lengths(noise) => {
                // Columns of the transpose are the rows.
                let blocks: Vec<_> = groups
                    .clone()
                    .map(|group| noise.block(group))
                    .map(|(own, coupling)| (own, coupling.transpose()))
                    .collect();
                let (mut own, mut coupling): ([&[f64]; LANES], [&[f64]; LANES]) =
                    ([&[]; LANES], [&[]; LANES]);
                for (lane, block) in blocks.iter().enumerate() {
                    own[lane] = block.0.as_slice();
                    coupling[lane] = block.1.as_slice();
                }
                side_by_side(own, own[0].len(), &mut of_groups.own);
                side_by_side(coupling, coupling[0].len(), &mut of_groups.coupling);
            }
            NoiseSource::Independent(blocks) => {
                let mut slices: [&[f64]; LANES] = [&[]; LANES];
                for (slice, group) in slices.iter_mut().zip(groups.clone()) {
                    *slice = blocks[group].as_slice();
                }
                side_by_side(slices, blocks[groups.start].len(), &mut of_groups.own);
                of_groups.coupling.clear();
            }
        }
        errors.take(places, self.variance_factor);
    }

    /// `D` and `Z` of the points at these places of a group; `errors` is memory to work in.
    pub(crate) fn of_group(
        &self,
        group: usize,
        places: &[usize],
        errors: &mut ChunkErrors,
    ) -> (DMatrix<f64>, DMatrix<f64>) {
        let groups = &self.batches[batch_of(group, &self.batches)];
        self.fill(groups, places, errors);
        errors.in_lane(group - groups.start)
    }

    /// `Σ`. It is indefinite and makes sense only between couplings, but for the stations.
    pub(crate) fn shared(&self) -> DMatrix<f64> {
        let unscaled = match &self.source {
            NoiseSource::Adjusted(screened) => {
                dense(screened.solution.covariance.reduced_inverse())
            }
            NoiseSource::Lengths(noise) => noise.shared().clone(),
            NoiseSource::Independent(_) => DMatrix::zeros(0, 0),
        };
        unscaled * self.variance_factor
    }

    /// `D_i + Z_i Σ Z_iᵀ` of a group of so many points.
    pub(crate) fn total(&self, group: usize, points: usize) -> DMatrix<f64> {
        let places: Vec<usize> = (0..points).collect();
        let (own, coupling) = self.of_group(group, &places, &mut ChunkErrors::default());
        let total = own + &coupling * self.shared() * coupling.transpose();
        // Symmetric to the last bit, as the identification asks.
        (&total + total.transpose()) * 0.5
    }
}

fn dense(matrix: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
