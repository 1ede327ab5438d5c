//! The sums of the reduced system, one for each lane of the batches that are added.

use crate::block_batch::RUN;
use crate::lanes::{Lanes, add_several_times, lanes_only, zeros};
use crate::reduced::Reduced;

/// Sums over batches of blocks; [`LaneSums::reduced`] adds up the lanes.
#[derive(Debug, Clone, Default)]
pub struct LaneSums {
    shared: usize,
    datum: usize,
    /// Rows `[W | W_H | c]` whose products are not yet taken off, one after the other.
    rows: Vec<Lanes>,
    /// Length of a row: `shared + datum + 1`, or one more so that it is even.
    row_len: usize,
    /// Their products for pairs of columns, upper triangle: the four products of each two pairs.
    products: Vec<[Lanes; 4]>,
    /// `[B | 0 | r]ᵀ [B | 0 | r]` and the closure, upper triangle in whole rows.
    matrix: Vec<Lanes>,
    squares: Lanes,
    observations: usize,
    block_unknowns: usize,
}

/// Rows whose products are added together: they are summed in registers. More would not stay in the
/// nearest cache.
const WAITING: usize = 18;

impl LaneSums {
    /// Zero sums for `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        let mut sums = Self::default();
        sums.reset(shared, datum);
        sums
    }

    /// Makes these zero sums; keeps the memory.
    pub fn reset(&mut self, shared: usize, datum: usize) {
        let width = shared + datum + 1;
        (self.shared, self.datum) = (shared, datum);
        self.row_len = width.next_multiple_of(2);
        self.rows.clear();
        let pairs = self.row_len / 2;
        zeros(&mut self.products, pairs * (pairs + 1) / 2);
        zeros(&mut self.matrix, width * width);
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
        self.add_products();
        let width = self.width();
        let mut matrix = vec![0.0; width * width];
        for i in 0..width {
            for j in i..width {
                matrix[i * width + j] = self.matrix[i * width + j].sum();
            }
        }
        let pairs = self.row_len / 2;
        let of_pairs = (0..pairs).flat_map(|p| (p..pairs).map(move |q| (p, q)));
        for ((p, q), products) in of_pairs.zip(&self.products) {
            for (k, product) in products.iter().enumerate() {
                let (i, j) = (2 * p + k / 2, 2 * q + k % 2);
                if i <= j && j < width {
                    matrix[i * width + j] -= product.sum();
                }
            }
        }
        let mut reduced = Reduced::from_sums(self.shared, self.datum, matrix);
        reduced.count(self.observations, self.block_unknowns, self.squares.sum());
        reduced
    }

    #[inline(always)]
    fn width(&self) -> usize {
        self.shared + self.datum + 1
    }

    /// Adds the products of some whitened rows `[run | others | r]`, whose run of shared unknowns, if there are runs,
    /// begins at `start`, and the others at `first`.
    #[inline(always)]
    pub(crate) fn add_rows<const N: usize>(
        &mut self,
        (has_runs, start, first): (bool, usize, usize),
        rows: [&[Lanes]; N],
    ) {
        let width = self.width();
        let others = self.shared - first;
        let tails = rows.map(|row| &row[RUN..]);
        let residuals = tails.map(|tail| &tail[others..]);
        if has_runs {
            for i in 0..RUN {
                let sums = &mut self.matrix[(start + i) * width..][..width];
                let factors = rows.map(|row| row[i]);
                // The whole run costs less than a loop over a part of it; what is below is not looked at.
                add_several_times(&mut sums[start..start + RUN], factors, rows);
                add_several_times(&mut sums[first..first + others], factors, tails);
                add_several_times(&mut sums[width - 1..], factors, residuals);
            }
        }
        for i in 0..others {
            let sums = &mut self.matrix[(first + i) * width..][..width];
            let factors = tails.map(|tail| tail[i]);
            let from = tails.map(|tail| &tail[i..]);
            add_several_times(&mut sums[first + i..first + others], factors, from);
            add_several_times(&mut sums[width - 1..], factors, residuals);
        }
        for residual in residuals {
            self.squares = residual[0].mul_add(residual[0], self.squares);
        }
    }

    /// Takes off the products of a row `[W | W_H | c]` of the blocks' own unknowns.
    #[inline(always)]
    pub(crate) fn take_off_row(&mut self, row: &[Lanes]) {
        if self.rows.len() == WAITING * self.row_len {
            self.add_products();
        }
        self.rows.extend_from_slice(row);
        if self.row_len > row.len() {
            self.rows.push(Lanes::ZERO);
        }
    }

    /// Adds the products of the rows that wait.
    #[inline(always)]
    fn add_products(&mut self) {
        let mut sums = self.products.iter_mut();
        for left in (0..self.row_len).step_by(2) {
            for (right, sums) in (left..self.row_len).step_by(2).zip(&mut sums) {
                let [mut ac, mut ad, mut bc, mut bd] = *sums;
                for row in self.rows.chunks_exact(self.row_len) {
                    lanes_only();
                    let ([a, b], [c, d]) = (pair(row, left), pair(row, right));
                    ac = a.mul_add(c, ac);
                    ad = a.mul_add(d, ad);
                    bc = b.mul_add(c, bc);
                    bd = b.mul_add(d, bd);
                }
                *sums = [ac, ad, bc, bd];
            }
        }
        self.rows.clear();
    }

    /// Adds to `h` of a constraint, by its place behind the shared unknowns.
    #[inline(always)]
    pub(crate) fn add_to_closure(&mut self, place: usize, value: Lanes) {
        let width = self.width();
        self.matrix[place * width + width - 1] += value;
    }
}

#[inline(always)]
fn pair(row: &[Lanes], first: usize) -> [Lanes; 2] {
    [row[first], row[first + 1]]
}
