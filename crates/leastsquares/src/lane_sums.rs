//! The sums of the reduced system, one for each lane of the batches that are added.

use crate::block_batch::QUAD;
use crate::lanes::{Lanes, lanes_only, zeros};
use crate::reduced::Reduced;

/// Sums over batches of blocks; [`LaneSums::reduced`] adds up the lanes.
#[derive(Debug, Clone, Default)]
pub struct LaneSums {
    shared: usize,
    datum: usize,
    /// Pairs of columns `[B | r | H]`.
    pairs: usize,
    /// `WᵀW - BᵀB` with the right sides, for pairs of columns, upper triangle: the four products of each two pairs.
    products: Vec<[Lanes; 4]>,
    squares: Lanes,
    observations: usize,
    block_unknowns: usize,
}

impl LaneSums {
    /// Zero sums for `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        let mut sums = Self::default();
        sums.reset(shared, datum);
        sums
    }

    /// Makes these zero sums; keeps the memory.
    pub fn reset(&mut self, shared: usize, datum: usize) {
        (self.shared, self.datum) = (shared, datum);
        self.pairs = (shared + 1 + datum).div_ceil(2);
        zeros(&mut self.products, self.pairs * (self.pairs + 1) / 2);
        self.squares = Lanes::ZERO;
        (self.observations, self.block_unknowns) = (0, 0);
    }

    /// Counts rows, and unknowns of blocks.
    pub fn count(&mut self, observations: usize, block_unknowns: usize) {
        self.observations += observations;
        self.block_unknowns += block_unknowns;
    }

    /// The sums over all lanes.
    #[inline(always)]
    pub fn reduced(&mut self) -> Reduced {
        let width = self.shared + 1 + self.datum;
        let mut matrix = vec![0.0; width * width];
        // The right side comes last.
        let place = |column: usize| match column.checked_sub(self.shared) {
            None => column,
            Some(0) => width - 1,
            Some(_) => column - 1,
        };
        let of_pairs = (0..self.pairs).flat_map(|p| (p..self.pairs).map(move |q| (p, q)));
        for ((p, q), products) in of_pairs.zip(&self.products) {
            for (k, product) in products.iter().enumerate() {
                let (i, j) = (2 * p + k / 2, 2 * q + k % 2);
                if i <= j && j < width {
                    let (i, j) = (place(i), place(j));
                    matrix[i.min(j) * width + i.max(j)] = -product.sum();
                }
            }
        }
        let mut reduced = Reduced::from_sums(self.shared, self.datum, matrix);
        reduced.count(self.observations, self.block_unknowns, self.squares.sum());
        reduced
    }

    /// Adds the products of some whitened rows `[quad | others | r]`, whose quad of shared unknowns, if there are quads,
    /// begins at `start`, and the others at `first`.
    #[inline(always)]
    pub(crate) fn add_rows<const N: usize>(
        &mut self,
        (start, first): (Option<usize>, usize),
        rows: [&[Lanes]; N],
    ) {
        const OF_QUAD: usize = QUAD / 2;
        let residual = self.shared - first + QUAD;
        let pair_at = |p: usize| match p.checked_sub(OF_QUAD) {
            None => start.unwrap_or(0) / 2 + p,
            Some(behind) => first / 2 + behind,
        };
        let count = residual / 2 + 1;
        // That of the residuals would drown what the unknowns take off it.
        let (tile, k) = self.of_residual();
        let apart = self.products[tile][k];
        for p in start.map_or(OF_QUAD, |_| 0)..count {
            let left = pair_at(p);
            let of_left = self.row(left);
            for q in p..count {
                let mut sum = self.products[of_left + pair_at(q) - left];
                for row in rows {
                    lanes_only();
                    let [a, b] = pair(row, 2 * p);
                    add_products(&mut sum, [-a, -b], pair(row, 2 * q));
                }
                self.products[of_left + pair_at(q) - left] = sum;
            }
        }
        self.products[tile][k] = apart;
        for row in rows {
            self.squares = row[residual].mul_add(row[residual], self.squares);
        }
    }

    /// Where the product of the right side with itself is.
    #[inline(always)]
    fn of_residual(&self) -> (usize, usize) {
        (self.row(self.shared / 2), 3 * (self.shared % 2))
    }

    /// Where the products of a pair with itself and those behind it start.
    #[inline(always)]
    fn row(&self, pair: usize) -> usize {
        pair * (2 * self.pairs - pair + 1) / 2
    }

    /// Takes off the products of the rows `[W | c | W_H]` of the blocks' own unknowns: those are behind `first` in rows of
    /// some length.
    #[inline(always)]
    pub(crate) fn take_off_rows(&mut self, rows: &[Lanes], length: usize, first: usize) {
        let mut sums = self.products.iter_mut();
        for left in (first..length).step_by(2) {
            for (right, sums) in (left..length).step_by(2).zip(&mut sums) {
                let mut sum = *sums;
                for row in rows.chunks_exact(length) {
                    lanes_only();
                    add_products(&mut sum, pair(row, left), pair(row, right));
                }
                *sums = sum;
            }
        }
    }

    /// Adds to `h` of a constraint.
    #[inline(always)]
    pub(crate) fn add_to_closure(&mut self, constraint: usize, value: Lanes) {
        let (right_side, column) = (self.shared, self.shared + 1 + constraint);
        let place = self.row(right_side / 2) + column / 2 - right_side / 2;
        self.products[place][2 * (right_side % 2) + column % 2] -= value;
    }
}

/// Adds the four products of two pairs.
#[inline(always)]
fn add_products([ac, ad, bc, bd]: &mut [Lanes; 4], [a, b]: [Lanes; 2], [c, d]: [Lanes; 2]) {
    *ac = a.mul_add(c, *ac);
    *ad = a.mul_add(d, *ad);
    *bc = b.mul_add(c, *bc);
    *bd = b.mul_add(d, *bd);
}

#[inline(always)]
fn pair(row: &[Lanes], first: usize) -> [Lanes; 2] {
    let pair = &row[first..first + 2];
    [pair[0], pair[1]]
}
