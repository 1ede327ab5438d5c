//! Eight blocks of the same shape, linearised and eliminated side by side.
//!
//! A block's whitened rows are `[A | B | r]`. Few of the shared unknowns are in a row: a quad of
//! four that stand side by side (a station), and columns behind all quads that any row may use.
//! With the Cholesky factor `AᵀA = RᵀR` and what ties the blocks to the rest,
//!
//! ```text
//! [W | W_H | c] = R⁻ᵀ [AᵀB | H | Aᵀr]
//! ```
//!
//! the block gives `[B | r]ᵀ [B | r] - [W | W_H | c]ᵀ [W | W_H | c]` to the reduced system
//! ([`crate::Reduced`]), its Schur complement, and its unknowns follow from those of the reduced system by
//! `x = R⁻¹ (c - W s - W_H λ)`. A square of a pivot of `R` is what is left of a column after those before it:
//! relative to the column it says whether an unknown is determined. All of it belongs into
//! [`crate::in_widest_registers`]; outside it is right, but slow.

mod back_substitution;
mod elimination;

use crate::lanes::{LANES, Lanes, add_times, lanes_only, multiply, zeros};

/// Shared unknowns that stand side by side in a row.
pub(crate) const QUAD: usize = 4;

/// What is left of a column after the columns before it, relative to its length, below which an
/// unknown counts as free: its uncertainty would be a million times that of a direct reading.
pub const BLOCK_RANK_TOL: f64 = 1e-6;

/// Eight blocks, and memory for their elimination.
#[derive(Debug, Clone, Default)]
pub struct BlockBatch {
    shape: Shape,
    /// The rows `[A | quad | others | r]`, one after the other.
    rows: Vec<Lanes>,
    /// Where the quad of each row starts.
    starts: Vec<usize>,
    /// Columns of `H`, contiguous.
    datum: Vec<Lanes>,
    closure: Vec<Lanes>,
    /// `[R | W | c | W_H]`, rows one after the other; of the diagonal the reciprocals, and nothing that counts below it.
    system: Vec<Lanes>,
    own_column: Vec<Lanes>,
}

/// The sizes of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shape {
    /// Rows of each block; a block with fewer has zeros in the others.
    pub rows: usize,
    /// Unknowns of each block.
    pub unknowns: usize,
    /// Shared unknowns in quads, an even number: they come first, and each quad starts at an even one.
    pub in_quads: usize,
    /// All shared unknowns.
    pub shared: usize,
    /// Constraints of the datum.
    pub datum: usize,
}

impl Shape {
    /// Where the residual is in a row: behind own unknowns, a quad, and the unknowns behind the quads.
    #[inline(always)]
    fn residual(&self) -> usize {
        self.unknowns + QUAD + self.shared - self.in_quads
    }

    /// Elements of a row: one of zero at its end where those behind the quad are odd, since their products are made in pairs.
    #[inline(always)]
    fn row_len(&self) -> usize {
        self.unknowns + QUAD + (self.shared - self.in_quads + 1).next_multiple_of(2)
    }

    /// Elements of a row of `[R | W | c | W_H]`, those behind `R` in pairs.
    #[inline(always)]
    fn system_len(&self) -> usize {
        self.unknowns + (self.shared + 1 + self.datum).next_multiple_of(2)
    }
}

/// A row of eight blocks, to be filled: what is there is arbitrary.
#[derive(Debug)]
pub struct RowMut<'a> {
    /// Derivatives of the observation by the blocks' own unknowns.
    pub own: &'a mut [Lanes],
    /// The first shared unknown of the quad.
    pub start: &'a mut usize,
    /// Derivatives by those of the quad.
    pub quad: &'a mut [Lanes],
    /// Derivatives by the shared unknowns behind the quads.
    pub others: &'a mut [Lanes],
    /// Observed minus computed.
    pub residual: &'a mut Lanes,
}

impl BlockBatch {
    /// Makes these blocks of another shape, with a datum of zeros and rows that are to be filled; keeps the memory.
    #[inline(always)]
    pub fn reset(&mut self, shape: Shape) {
        self.shape = shape;
        self.rows.resize(shape.rows * shape.row_len(), Lanes::ZERO);
        zeros(&mut self.starts, shape.rows);
        zeros(&mut self.datum, shape.unknowns * shape.datum);
        zeros(&mut self.closure, shape.datum);
    }

    /// The sizes.
    pub(crate) fn shape(&self) -> Shape {
        self.shape
    }

    /// A row, to be filled.
    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> RowMut<'_> {
        let length = self.shape.row_len();
        let (own, rest) = self.rows[row * length..][..length].split_at_mut(self.shape.unknowns);
        let (quad, rest) = rest.split_at_mut(QUAD);
        let (others, rest) = rest.split_at_mut(self.shape.shared - self.shape.in_quads);
        rest[1..].fill(Lanes::ZERO);
        RowMut {
            own,
            start: &mut self.starts[row],
            quad,
            others,
            residual: &mut rest[0],
        }
    }

    /// Multiplies the rows from `first` on from the left by a lower triangle, its rows one after the other.
    #[inline(always)]
    pub fn whiten(&mut self, first: usize, count: usize, triangle: &[Lanes]) {
        let length = self.shape.row_len();
        let rows = &mut self.rows[first * length..][..count * length];
        if let &[l11, l21, l22, l31, l32, l33] = triangle {
            let (upper, rest) = rows.split_at_mut(length);
            let (middle, lower) = rest.split_at_mut(length);
            for ((x, y), z) in upper.iter_mut().zip(middle).zip(lower) {
                lanes_only();
                *z = l32.mul_add(*y, l31.mul_add(*x, *z * l33));
                *y = l21.mul_add(*x, *y * l22);
                *x = *x * l11;
            }
            return;
        }
        // From below: each row needs those above it as they were.
        for i in (0..count).rev() {
            let weights = &triangle[i * (i + 1) / 2..][..=i];
            let (above, row) = rows.split_at_mut(i * length);
            let row = &mut row[..length];
            multiply(row, weights[i]);
            for (above, w) in above.chunks_exact(length).zip(weights) {
                add_times(row, *w, above);
            }
        }
    }

    #[inline(always)]
    fn row(&self, row: usize) -> &[Lanes] {
        let length = self.shape.row_len();
        &self.rows[row * length..][..length]
    }

    /// The derivatives of a row by the blocks' own unknowns.
    #[inline(always)]
    pub(crate) fn own_row(&self, row: usize) -> &[Lanes] {
        &self.row(row)[..self.shape.unknowns]
    }

    /// The residual of a row, observed minus computed.
    #[inline(always)]
    pub(crate) fn residual(&self, row: usize) -> Lanes {
        self.row(row)[self.shape.residual()]
    }

    /// Writes the shared unknowns' elements of a row to the front of `place`, which is zero.
    #[inline(always)]
    pub fn copy_shared_row(&self, row: usize, place: &mut [Lanes]) {
        let Shape { in_quads, .. } = self.shape;
        let (quad, rest) = self.row(row)[self.shape.unknowns..self.shape.residual()].split_at(QUAD);
        if in_quads > 0 {
            place[self.starts[row]..][..QUAD].copy_from_slice(quad);
        }
        place[in_quads..][..rest.len()].copy_from_slice(rest);
    }

    /// Column `k` of `H`, to be filled.
    #[inline(always)]
    pub fn datum_mut(&mut self, k: usize) -> &mut [Lanes] {
        let n = self.shape.unknowns;
        &mut self.datum[k * n..(k + 1) * n]
    }

    /// The blocks' parts of what the constraints shall come to, `h`.
    #[inline(always)]
    pub fn closure_mut(&mut self) -> &mut [Lanes] {
        &mut self.closure
    }

    /// Makes the lanes from `used` on count for nothing; their own columns stay as they are.
    #[inline(always)]
    pub fn use_only(&mut self, used: usize) {
        if used == LANES {
            return;
        }
        let mask = Lanes::mask(used);
        let (length, unknowns) = (self.shape.row_len(), self.shape.unknowns);
        for row in self.rows.chunks_exact_mut(length) {
            for x in &mut row[unknowns..] {
                *x = *x * mask;
            }
        }
        for x in self.datum.iter_mut().chain(&mut self.closure) {
            *x = *x * mask;
        }
    }
}
