//! The factors of all eliminated blocks, eight side by side as they were eliminated: what a covariance needs of them.

use std::ops::Range;

use nalgebra::DMatrix;

use crate::lane_products::LaneMatrix;
use crate::lanes::Lanes;

/// `R⁻¹` and `Z = R⁻¹ [W | W_H]` of every block, batch after batch.
#[derive(Debug, Clone, Default)]
pub struct Factors {
    width: usize,
    batches: Vec<Place>,
    /// Of each chunk, as it was made, the batches one after the other.
    chunks: Vec<Vec<Lanes>>,
}

/// Where the factors of a batch are.
#[derive(Debug, Clone)]
struct Place {
    blocks: Range<usize>,
    unknowns: usize,
    chunk: usize,
    start: usize,
}

/// The factors of up to eight blocks. Lanes without a block hold finite numbers without meaning: rows of zeros are
/// multiplied by them.
#[derive(Debug, Clone, Copy)]
pub struct BatchFactors<'a> {
    /// Number of the first block.
    first: usize,
    /// `R⁻¹`: upper triangular.
    pub inverse_factor: LaneMatrix<'a>,
    /// `Z`: one column for each shared unknown and datum multiplier.
    pub coupling: LaneMatrix<'a>,
}

impl Factors {
    /// No factors yet: room for batches with these numbers of unknowns, and `width` columns of `Z`.
    pub fn with_room(width: usize, batches: impl Iterator<Item = usize>) -> Self {
        let numbers = batches.map(|unknowns| unknowns * (unknowns + width)).sum();
        Self {
            width,
            batches: Vec::new(),
            chunks: vec![Vec::with_capacity(numbers)],
        }
    }

    /// Begins a batch of blocks with these numbers and as many unknowns each. To what is returned the caller appends `R⁻¹`
    /// and then `Z`, rows one after the other.
    #[inline(always)]
    pub fn begin(&mut self, blocks: Range<usize>, unknowns: usize) -> &mut Vec<Lanes> {
        let chunk = self.chunks.len().saturating_sub(1);
        self.chunks.resize_with(chunk + 1, Vec::new);
        self.batches.push(Place {
            blocks,
            unknowns,
            chunk,
            start: self.chunks[chunk].len(),
        });
        &mut self.chunks[chunk]
    }

    /// Appends the factors of the batches that follow.
    pub fn append(&mut self, next: Self) {
        let before = self.chunks.len();
        self.width = next.width;
        self.chunks.extend(next.chunks);
        self.batches
            .extend(next.batches.into_iter().map(|place| Place {
                chunk: before + place.chunk,
                ..place
            }));
    }

    /// Columns of `Z`: the number of shared unknowns and datum multipliers.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of batches.
    pub(crate) fn batches(&self) -> usize {
        self.batches.len()
    }

    /// Batch `b`, in the order in which they were eliminated.
    #[inline(always)]
    pub fn batch(&self, b: usize) -> BatchFactors<'_> {
        let Place {
            ref blocks,
            unknowns: n,
            chunk,
            start,
        } = self.batches[b];
        let (inverse_factor, behind) = self.chunks[chunk][start..].split_at(n * n);
        BatchFactors {
            first: blocks.start,
            inverse_factor: LaneMatrix::by_rows(inverse_factor, [n; 2]),
            coupling: LaneMatrix::by_rows(&behind[..n * self.width], [n, self.width]),
        }
    }

    /// The numbers of the blocks of batch `b`.
    pub(crate) fn blocks(&self, b: usize) -> Range<usize> {
        self.batches[b].blocks.clone()
    }

    pub(crate) fn batch_of(&self, i: usize) -> BatchFactors<'_> {
        self.batch(self.batches.partition_point(|b| b.blocks.end <= i))
    }

    /// Number of unknowns of block `i`.
    pub fn unknowns(&self, i: usize) -> usize {
        self.batch_of(i).coupling.rows()
    }

    /// `R⁻¹` of block `i`: upper triangular.
    pub fn inverse_factor(&self, i: usize) -> DMatrix<f64> {
        let batch = self.batch_of(i);
        batch.matrix_in_lane(i, batch.inverse_factor)
    }

    /// `Zᵀ` of block `i`: one row for each shared unknown and datum multiplier.
    pub fn coupling_transposed(&self, i: usize) -> DMatrix<f64> {
        let batch = self.batch_of(i);
        batch.matrix_in_lane(i, batch.coupling.transposed())
    }
}

impl BatchFactors<'_> {
    /// The number of block `i`, of those of all blocks side by side.
    pub(crate) fn in_lane(&self, i: usize, lanes: Lanes) -> f64 {
        lanes.0[i - self.first]
    }

    fn matrix_in_lane(&self, i: usize, matrix: LaneMatrix<'_>) -> DMatrix<f64> {
        DMatrix::from_fn(matrix.rows(), matrix.columns(), |j, k| {
            self.in_lane(i, matrix.at(j, k))
        })
    }
}
