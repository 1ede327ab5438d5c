//! The sums of the reduced system, one for each lane of the batches that are added.

use crate::lanes::{Lanes, add_times, lanes_only};
use crate::reduced::Reduced;

/// Sums over batches of blocks; [`LaneSums::into_reduced`] adds up the lanes.
#[derive(Debug, Clone)]
pub struct LaneSums {
    shared: usize,
    datum: usize,
    /// Rows `[W | W_H | c]` whose products are not yet taken off, one after the other.
    rows: Vec<Lanes>,
    /// Length of a row: `shared + datum + 1`, or one more so that it is even.
    row_len: usize,
    /// Their products for pairs of columns, upper triangle: the four products of each two pairs. Empty
    /// before the first row.
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
        let width = shared + datum + 1;
        Self {
            shared,
            datum,
            rows: Vec::new(),
            row_len: width.next_multiple_of(2),
            products: Vec::new(),
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
    #[inline(always)]
    pub fn into_reduced(mut self) -> Reduced {
        self.add_products();
        let width = self.width();
        let mut matrix: Vec<f64> = self.matrix.iter().map(|x| x.sum()).collect();
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

    /// Adds the products of a whitened row `[B | r]`: a run of shared unknowns from `start` on, and those from
    /// `first` on.
    #[inline(always)]
    pub(crate) fn add_row(
        &mut self,
        (start, run): (usize, &[Lanes]),
        (first, others): (usize, &[Lanes]),
        residual: Lanes,
    ) {
        let width = self.width();
        for (i, a) in run.iter().enumerate() {
            let row = &mut self.matrix[(start + i) * width..][..width];
            // The whole run costs less than a loop over a part of it; what is below is not looked at.
            add_times(&mut row[start..start + run.len()], *a, run);
            add_times(&mut row[first..first + others.len()], *a, others);
            row[width - 1] = a.mul_add(residual, row[width - 1]);
        }
        for (i, a) in others.iter().enumerate() {
            let row = &mut self.matrix[(first + i) * width..][..width];
            add_times(&mut row[first + i..first + others.len()], *a, &others[i..]);
            row[width - 1] = a.mul_add(residual, row[width - 1]);
        }
        self.squares = residual.mul_add(residual, self.squares);
    }

    /// A row `[W | W_H | c]` of the blocks' own unknowns, to be filled.
    #[inline(always)]
    pub(crate) fn next_eliminated(&mut self) -> &mut [Lanes] {
        if self.products.is_empty() {
            let pairs = self.row_len / 2;
            self.products = vec![[Lanes::ZERO; 4]; pairs * (pairs + 1) / 2];
        }
        if self.rows.len() == WAITING * self.row_len {
            self.add_products();
        }
        let (first, width) = (self.rows.len(), self.width());
        self.rows.resize(first + self.row_len, Lanes::ZERO);
        &mut self.rows[first..][..width]
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
