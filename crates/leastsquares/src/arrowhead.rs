//! The block-arrowhead system: blocks are eliminated as they come, shared unknowns are solved last.
//!
//! For every block the reflected rows say `R x + C s = c`. With the datum's constraint
//! `Σ Hᵀ x = h` and its multipliers `λ`, and `t = (s, λ)`:
//!
//! ```text
//! x = d - Z t      d = R⁻¹ c     Z = R⁻¹ [C, R⁻ᵀ H]
//! ```
//!
//! and `t` solves the reduced system of [`crate::reduced`].

use crate::block::BlockRows;
use crate::covariance::Covariance;
use crate::error::Error;
use crate::reduced::{Datum, Reduced};

/// The system under construction. Blocks are numbered in the order of elimination.
#[derive(Debug, Clone)]
pub struct Arrowhead {
    reduced: Reduced,
    blocks: Vec<EliminatedBlock>,
    /// `R⁻¹` of every block, upper triangular, columns contiguous.
    inverse_factors: Vec<f64>,
    /// `Z` of every block, columns contiguous.
    couplings: Vec<f64>,
    /// `d` of every block.
    offsets: Vec<f64>,
    rows: usize,
    squares: f64,
}

#[derive(Debug, Clone, Copy)]
struct EliminatedBlock {
    unknowns: usize,
    /// Where its unknowns start among all blocks' unknowns.
    first: usize,
    /// Where its `R⁻¹` starts.
    inverse_factor: usize,
}

/// Corrections to all unknowns.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// To the shared unknowns.
    pub shared: Vec<f64>,
    blocks: Vec<f64>,
    starts: Vec<usize>,
}

impl Correction {
    /// To the unknowns of block `i`.
    pub fn block(&self, i: usize) -> &[f64] {
        &self.blocks[self.starts[i]..self.starts[i + 1]]
    }
}

/// A solved system.
#[derive(Debug, Clone)]
pub struct Solved {
    /// The corrections.
    pub correction: Correction,
    /// Sum of squares of the whitened residuals before the correction, `Σ|r|²`.
    pub squares: f64,
    /// By how much the linear model says that the correction lowers it. It is the squared length
    /// of the correction in units of standard uncertainty.
    pub predicted_decrease: f64,
    /// Covariance of all unknowns for unit variance of the whitened rows.
    pub covariance: Covariance,
}

impl Arrowhead {
    /// An empty system with `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        Self {
            reduced: Reduced::new(shared, datum),
            blocks: Vec::new(),
            inverse_factors: Vec::new(),
            couplings: Vec::new(),
            offsets: Vec::new(),
            rows: 0,
            squares: 0.0,
        }
    }

    /// Number of rows so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of unknowns so far, blocks and shared, less the free motions that the datum fixes.
    pub fn determined_unknowns(&self) -> usize {
        self.offsets.len() + self.reduced.shared() - self.reduced.datum()
    }

    /// Eliminates one block. `datum` is its `H`: one column of the block's size for each
    /// constraint, columns contiguous. The rows are used up.
    ///
    /// # Errors
    /// [`Error::TooFewRows`], [`Error::BlockRank`], [`Error::NotFinite`].
    ///
    /// # Panics
    /// If the block has no unknowns, or the shape of `datum` does not match.
    pub fn eliminate(&mut self, rows: &mut BlockRows, datum: &[f64]) -> Result<(), Error> {
        let n = rows.block_unknowns();
        let (shared, constraints) = (self.reduced.shared(), self.reduced.datum());
        assert!(n > 0, "a block has unknowns");
        assert_eq!(
            datum.len(),
            n * constraints,
            "one datum column of the block's size each"
        );
        self.rows += rows.rows();
        self.squares += rows.residual_mut().iter().map(|r| r * r).sum::<f64>();
        rows.triangularise(self.blocks.len())?;

        let inverse_factor = inverted_upper(n, |row, column| rows.column(column)[row]);
        let upper = |k: usize| &rows.column(n + k)[..n];
        // W = R⁻ᵀ H
        let mut weighted_datum = vec![0.0; n * constraints];
        for (w, h) in weighted_datum
            .chunks_exact_mut(n)
            .zip(datum.chunks_exact(n))
        {
            transposed_times(&inverse_factor, h, w);
        }
        self.reduced.add_rows(|k| &rows.column(n + k)[n..]);
        self.reduced
            .add_datum(upper, &weighted_datum, upper(shared));

        let mut z = vec![0.0; n];
        for k in 0..shared {
            times(&inverse_factor, upper(k), &mut z);
            self.couplings.extend_from_slice(&z);
        }
        for w in weighted_datum.chunks_exact(n) {
            times(&inverse_factor, w, &mut z);
            self.couplings.extend_from_slice(&z);
        }
        times(&inverse_factor, upper(shared), &mut z);
        self.blocks.push(EliminatedBlock {
            unknowns: n,
            first: self.offsets.len(),
            inverse_factor: self.inverse_factors.len(),
        });
        self.offsets.extend_from_slice(&z);
        self.inverse_factors.extend_from_slice(&inverse_factor);
        Ok(())
    }

    /// Solves for all unknowns.
    ///
    /// # Errors
    /// [`Error::SharedRank`] if more than the datum's motions are free, [`Error::NotFinite`].
    pub fn solve(self, datum: &Datum) -> Result<Solved, Error> {
        let solution = self.reduced.solve(datum)?;
        let width = self.reduced.shared() + self.reduced.datum();
        let mut starts = vec![0];
        let mut corrections = self.offsets.clone();
        for block in &self.blocks {
            let (first, n) = (block.first, block.unknowns);
            starts.push(first + n);
            let x = &mut corrections[first..first + n];
            let z = &self.couplings[first * width..(first + n) * width];
            for (column, t) in z.chunks_exact(n).zip(&solution.unknowns) {
                for (x, z) in x.iter_mut().zip(column) {
                    *x -= z * t;
                }
            }
        }
        let block_decrease = self.reduced.block_squares();
        let correction = Correction {
            shared: solution.unknowns[..self.reduced.shared()].to_vec(),
            blocks: corrections,
            starts: starts.clone(),
        };
        let covariance = Covariance::new(
            self.reduced.shared(),
            starts,
            self.blocks.iter().map(|b| b.inverse_factor).collect(),
            self.inverse_factors,
            self.couplings,
            solution.inverse,
        );
        Ok(Solved {
            correction,
            squares: self.squares,
            predicted_decrease: block_decrease + solution.decrease,
            covariance,
        })
    }
}

/// Inverse of an upper triangular matrix, columns contiguous.
fn inverted_upper(n: usize, r: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut inverse = vec![0.0; n * n];
    for column in 0..n {
        inverse[column * n + column] = 1.0 / r(column, column);
        for row in (0..column).rev() {
            let sum: f64 = (row + 1..=column)
                .map(|k| r(row, k) * inverse[column * n + k])
                .sum();
            inverse[column * n + row] = -sum / r(row, row);
        }
    }
    inverse
}

/// `out = M x` for a square matrix with contiguous columns.
fn times(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    for (column, x) in matrix.chunks_exact(out.len()).zip(x) {
        for (o, m) in out.iter_mut().zip(column) {
            *o += m * x;
        }
    }
}

/// `out = Mᵀ x` for a square matrix with contiguous columns.
fn transposed_times(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    for (o, column) in out.iter_mut().zip(matrix.chunks_exact(x.len())) {
        *o = column.iter().zip(x).map(|(m, x)| m * x).sum();
    }
}
