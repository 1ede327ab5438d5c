//! The sums of the reduced system, one for each lane of the batches that are added.

use crate::lanes::{Lanes, lanes_only};
use crate::reduced::Reduced;

/// Sums over batches of blocks; [`LaneSums::into_reduced`] adds up the lanes.
#[derive(Debug, Clone)]
pub struct LaneSums {
    shared: usize,
    datum: usize,
    /// The bordered matrix of [`Reduced`], of the symmetric part the upper triangle.
    matrix: Vec<Lanes>,
    squares: Lanes,
    observations: usize,
    block_unknowns: usize,
}

impl LaneSums {
    /// Zero sums for `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        let width = shared + datum + 1;
        Self {
            shared,
            datum,
            matrix: vec![Lanes::ZERO; width * width],
            squares: Lanes::ZERO,
            observations: 0,
            block_unknowns: 0,
        }
    }

    /// Counts rows, and unknowns of blocks.
    pub fn count(&mut self, observations: usize, block_unknowns: usize) {
        self.observations += observations;
        self.block_unknowns += block_unknowns;
    }

    /// The sums over all lanes.
    pub fn into_reduced(self) -> Reduced {
        let matrix = self.matrix.iter().map(|x| x.sum()).collect();
        let mut reduced = Reduced::from_sums(self.shared, self.datum, matrix);
        reduced.count(self.observations, self.block_unknowns, self.squares.sum());
        reduced
    }

    #[inline(always)]
    fn width(&self) -> usize {
        self.shared + self.datum + 1
    }

    #[inline(always)]
    pub(crate) fn add_squares(&mut self, squares: Lanes) {
        self.squares += squares;
    }

    /// `[m | r]ᵀ [m | r]` of a row that is free of the blocks' unknowns, without `r²`.
    #[inline(always)]
    pub(crate) fn add_row(&mut self, row: &[Lanes]) {
        let (width, shared) = (self.width(), self.shared);
        let (m, r) = (&row[..shared], row[shared]);
        let rows = self.matrix.chunks_exact_mut(width);
        for (i, (sums, &own)) in rows.zip(m).enumerate() {
            for (sum, other) in sums[i..shared].iter_mut().zip(&m[i..]) {
                lanes_only();
                *sum += own * *other;
            }
            sums[width - 1] += own * r;
        }
    }

    /// `-q b` between a shared unknown and a constraint.
    #[inline(always)]
    pub(crate) fn add_to_border(&mut self, shared: usize, datum: usize, product: Lanes) {
        let place = shared * self.width() + self.shared + datum;
        self.matrix[place] -= product;
    }

    /// `-Wᵀ W` between two constraints.
    #[inline(always)]
    pub(crate) fn add_to_datum(&mut self, k: usize, l: usize, product: Lanes) {
        let place = (self.shared + k) * self.width() + self.shared + l;
        self.matrix[place] -= product;
    }

    /// `h - Wᵀ c` of a constraint.
    #[inline(always)]
    pub(crate) fn add_to_closure(&mut self, k: usize, value: Lanes) {
        let place = (self.shared + k + 1) * self.width() - 1;
        self.matrix[place] += value;
    }

    /// `-cᵀ c`.
    #[inline(always)]
    pub(crate) fn add_to_corner(&mut self, squares: Lanes) {
        if let Some(corner) = self.matrix.last_mut() {
            *corner -= squares;
        }
    }
}
