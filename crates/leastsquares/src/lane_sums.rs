//! The sums of the reduced system, one for each lane of the batches that are added.

use crate::block_batch::RUN;
use crate::lanes::{Lanes, lanes_only};
use crate::reduced::Reduced;
use crate::run_pairs::RunPairs;

/// Sums over batches of blocks; [`LaneSums::into_reduced`] adds up the lanes.
#[derive(Debug, Clone)]
pub struct LaneSums {
    shared: usize,
    datum: usize,
    /// Rows `[m | r]` whose products are not yet added, one after the other.
    rows: Vec<Lanes>,
    /// Length of a row: `shared + 1`, or one more so that it is even.
    row_len: usize,
    /// `[m | r]ᵀ [m | r]` for pairs of columns, upper triangle: the four products of each two pairs. Empty
    /// before the first row.
    products: Vec<[Lanes; 4]>,
    /// The same for rows that have a run of shared unknowns each.
    run_pairs: RunPairs,
    /// What is added to the bordered matrix of [`Reduced`] for the constraints; empty if there are none.
    matrix: Vec<Lanes>,
    squares: Lanes,
    /// `Σ c²`.
    taken: Lanes,
    observations: usize,
    block_unknowns: usize,
}

/// Rows whose products are added together: they are summed in registers. More would not stay in the
/// nearest cache.
const WAITING: usize = 16;

impl LaneSums {
    /// Zero sums for `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        let width = if datum == 0 { 0 } else { shared + datum + 1 };
        Self {
            shared,
            datum,
            rows: Vec::new(),
            row_len: (shared + 1).next_multiple_of(2),
            products: Vec::new(),
            run_pairs: RunPairs::default(),
            matrix: vec![Lanes::ZERO; width * width],
            squares: Lanes::ZERO,
            taken: Lanes::ZERO,
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
        matrix.resize(width * width, 0.0);
        let pairs = self.row_len / 2;
        let of_pairs = (0..pairs).flat_map(|p| (p..pairs).map(move |q| (p, q)));
        for ((p, q), products) in of_pairs.zip(&self.products) {
            for (k, product) in products.iter().enumerate() {
                let (i, j) = (2 * p + k / 2, 2 * q + k % 2);
                if i < self.shared && i <= j && j <= self.shared {
                    let column = if j == self.shared { width - 1 } else { j };
                    matrix[i * width + column] += product.sum();
                }
            }
        }
        self.run_pairs.add_to(width, &mut matrix);
        if let Some(corner) = matrix.last_mut() {
            *corner -= self.taken.sum();
        }
        let mut reduced = Reduced::from_sums(self.shared, self.datum, matrix);
        reduced.count(self.observations, self.block_unknowns, self.squares.sum());
        reduced
    }

    #[inline(always)]
    fn width(&self) -> usize {
        self.shared + self.datum + 1
    }

    /// Adds whitened residuals of the blocks, `Σ r²`.
    #[inline(always)]
    pub fn add_squares(&mut self, squares: Lanes) {
        self.squares += squares;
    }

    /// A row `[m | r]` that is free of the blocks' unknowns, to be filled: zeros.
    #[inline(always)]
    pub fn next_row(&mut self) -> &mut [Lanes] {
        if self.products.is_empty() {
            let pairs = self.row_len / 2;
            self.products = vec![[Lanes::ZERO; 4]; pairs * (pairs + 1) / 2];
        }
        if self.rows.len() == WAITING * self.row_len {
            self.add_products();
        }
        let first = self.rows.len();
        self.rows.resize(first + self.row_len, Lanes::ZERO);
        &mut self.rows[first..][..self.shared + 1]
    }

    /// Adds rows `B` that have a run of shared unknowns each, of which what the blocks leave is not
    /// eliminated but projected: the `runs`, the upper triangle of the `projection` `P`, and what it leaves
    /// of the `residual`. The `first` unknowns of the runs are multiples of [`RUN`] and ascend strictly.
    #[inline(always)]
    pub fn add_runs<const ROWS: usize>(
        &mut self,
        first: impl Iterator<Item = usize> + Clone,
        runs: &[[Lanes; RUN]; ROWS],
        projection: &[[Lanes; ROWS]; ROWS],
        residual: &[Lanes; ROWS],
    ) {
        let run_of_row = first.map(
            #[inline(always)]
            |first| first / RUN,
        );
        let pairs = &mut self.run_pairs;
        pairs.add(self.shared / RUN, run_of_row, runs, projection, residual);
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

    /// `-Bᵀ q` between the shared unknowns and a constraint.
    #[inline(always)]
    pub(crate) fn add_to_border(&mut self, datum: usize, products: &[Lanes]) {
        let (width, column) = (self.width(), self.shared + datum);
        for (row, product) in self.matrix.chunks_exact_mut(width).zip(products) {
            row[column] -= *product;
        }
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

    /// Adds what the blocks take off the sum of squares whatever the shared unknowns are, `Σ c²`.
    #[inline(always)]
    pub fn add_taken(&mut self, squares: Lanes) {
        self.taken += squares;
    }
}

#[inline(always)]
fn pair(row: &[Lanes], first: usize) -> [Lanes; 2] {
    [row[first], row[first + 1]]
}
