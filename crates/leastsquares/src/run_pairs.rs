//! Sums of products of rows that have four shared unknowns each.
//!
//! What the elimination of a block leaves of its rows `B_i` and residuals `r` is their projection `P` on
//! what the block's own unknowns do not explain. If each row has a run of four shared unknowns, the sums
//!
//! ```text
//! MᵀM = Σ B_iᵀ P_ij B_j        Mᵀr = Σ B_iᵀ (P r)_i
//! ```
//!
//! are fewer products run by run than by whole rows of `M`.

use crate::block_batch::RUN;
use crate::lanes::{Lanes, lanes_only};

/// Batches whose products are added together: they are summed in registers.
const WAITING: usize = 8;

/// Products of two runs.
type Block = [[Lanes; RUN]; RUN];

/// Sums for the pairs of some runs.
#[derive(Debug, Clone, Default)]
pub(crate) struct RunPairs {
    /// Number of runs.
    runs: usize,
    /// Of the pairs of runs, the first not behind the second, row by row.
    blocks: Vec<Block>,
    right: Vec<[Lanes; RUN]>,
    /// The run of each row of the batches that wait.
    run_of_row: Vec<usize>,
    /// One batch after the other, the elements of `B` row by row and behind them those of the upper
    /// triangle of `P`.
    waiting: Vec<Lanes>,
    /// Number of batches that wait.
    batches: usize,
}

impl RunPairs {
    /// Adds the rows of a batch: `B`, the upper triangle of `P`, and `P r`. The runs of the rows must
    /// ascend strictly.
    #[inline(always)]
    pub(crate) fn add<const ROWS: usize>(
        &mut self,
        runs: usize,
        run_of_row: impl Iterator<Item = usize> + Clone,
        rows: &[[Lanes; RUN]; ROWS],
        projection: &[[Lanes; ROWS]; ROWS],
        residual: &[Lanes; ROWS],
    ) {
        if self.blocks.is_empty() {
            self.runs = runs;
            self.blocks = vec![[[Lanes::ZERO; RUN]; RUN]; runs * (runs + 1) / 2];
            self.right = vec![[Lanes::ZERO; RUN]; runs];
        }
        if !self.run_of_row.iter().copied().eq(run_of_row.clone()) {
            self.add_products();
            self.run_of_row.clear();
            self.run_of_row.extend(run_of_row);
            debug_assert!(self.run_of_row.is_sorted_by(|a, b| a < b), "ascending runs");
            self.waiting.resize(WAITING * self.batch_len(), Lanes::ZERO);
        }
        for ((&run, row), r) in self.run_of_row.iter().zip(rows).zip(residual) {
            for (sum, x) in self.right[run].iter_mut().zip(row) {
                *sum = x.mul_add(*r, *sum);
            }
        }
        let len = self.batch_len();
        let mut places = self.waiting[self.batches * len..][..len].iter_mut();
        for (x, place) in rows.as_flattened().iter().zip(&mut places) {
            lanes_only();
            *place = *x;
        }
        for (i, row) in projection.iter().enumerate() {
            for (p, place) in row[i..].iter().zip(&mut places) {
                lanes_only();
                *place = *p;
            }
        }
        self.batches += 1;
        if self.batches == WAITING {
            self.add_products();
        }
    }

    /// Numbers that wait for each batch.
    #[inline(always)]
    fn batch_len(&self) -> usize {
        let rows = self.run_of_row.len();
        RUN * rows + rows * (rows + 1) / 2
    }

    /// Adds the products of the batches that wait.
    #[inline(always)]
    fn add_products(&mut self) {
        let (rows, len) = (self.run_of_row.len(), self.batch_len());
        let waiting = &self.waiting[..self.batches * len];
        let mut pair = RUN * rows;
        for (i, &left) in self.run_of_row.iter().enumerate() {
            for (j, &right) in self.run_of_row.iter().enumerate().skip(i) {
                let block = &mut self.blocks[pair_number(self.runs, left, right)];
                let mut sums = *block;
                for batch in waiting.chunks_exact(len) {
                    lanes_only();
                    let (runs, p) = (batch.as_chunks::<RUN>().0, batch[pair]);
                    add_product(&runs[i], p, &runs[j], &mut sums);
                }
                *block = sums;
                pair += 1;
            }
        }
        self.batches = 0;
    }

    /// Adds up the lanes into the upper triangle of a bordered matrix, with rows of `width` elements.
    #[inline(always)]
    pub(crate) fn add_to(&mut self, width: usize, matrix: &mut [f64]) {
        self.add_products();
        let mut blocks = self.blocks.iter();
        for i in 0..self.runs {
            for (j, block) in (i..self.runs).zip(&mut blocks) {
                for (k, sums) in block.iter().enumerate() {
                    let row = &mut matrix[(RUN * i + k) * width + RUN * j..][..RUN];
                    let before = if i == j { k } else { 0 };
                    for (x, sum) in row.iter_mut().zip(sums).skip(before) {
                        *x += sum.sum();
                    }
                }
            }
        }
        for (i, sum) in self.right.iter().flatten().enumerate() {
            matrix[(i + 1) * width - 1] += sum.sum();
        }
    }
}

/// Place of a pair of runs in the upper triangle.
#[inline(always)]
fn pair_number(runs: usize, left: usize, right: usize) -> usize {
    left * (2 * runs - left - 1) / 2 + right
}

/// `sums += aᵀ p b`.
#[inline(always)]
fn add_product(a: &[Lanes; RUN], p: Lanes, b: &[Lanes; RUN], sums: &mut Block) {
    for (a, sums) in a.iter().zip(sums) {
        let a = *a * p;
        for (b, sum) in b.iter().zip(sums) {
            *sum = a.mul_add(*b, *sum);
        }
    }
}
