//! The block-arrowhead system: blocks are eliminated as they come, shared unknowns are solved last.
//!
//! For every block the reflected rows say `R x + C s = c`. With the datum's constraint
//! `Σ Hᵀ x = h` and its multipliers `λ`, and `t = (s, λ)`:
//!
//! ```text
//! x = R⁻¹ c - Z t        Z = R⁻¹ [C, R⁻ᵀ H]
//! ```
//!
//! and `t` solves the reduced system ([`Reduced`]).

use crate::block::BlockRows;
use crate::covariance::Covariance;
use crate::eliminated::Block;
use crate::error::Error;
use crate::factors::Factors;
use crate::reduced::{Datum, Reduced};

/// A linear system under construction. Blocks are numbered in the order of elimination.
#[derive(Debug, Clone)]
pub struct Arrowhead {
    reduced: Reduced,
    memory: Block,
    factors: Factors,
    /// `R⁻¹ c` of every block.
    offsets: Vec<f64>,
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
            memory: Block::new(shared, datum),
            factors: Factors::zeros(shared + datum, std::iter::empty()),
            offsets: Vec::new(),
        }
    }

    /// Number of rows so far.
    pub fn rows(&self) -> usize {
        self.reduced.observations()
    }

    /// Number of unknowns so far, blocks and shared, less the free motions that the datum fixes.
    pub fn determined_unknowns(&self) -> usize {
        self.reduced.determined_unknowns()
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
        assert!(n > 0, "a block has unknowns");
        assert_eq!(
            datum.len(),
            n * self.reduced.datum(),
            "one datum column of the block's size each"
        );
        self.reduced.add_rows(rows);
        self.memory
            .eliminate_rows(self.factors.blocks(), rows, datum)?;
        self.reduced.add(&self.memory);
        self.factors.push(&self.memory);
        let first = self.offsets.len();
        self.offsets.resize(first + n, 0.0);
        self.memory.correction(&[], &mut self.offsets[first..]);
        Ok(())
    }

    /// Solves for all unknowns.
    ///
    /// # Errors
    /// [`Error::SharedRank`] if more than the datum's motions are free, [`Error::NotFinite`].
    pub fn solve(mut self, datum: &Datum) -> Result<Solved, Error> {
        self.reduced.close(&datum.closure);
        let solution = self.reduced.solve(|| datum.free_motions.clone())?;
        let mut blocks = self.offsets;
        for i in 0..self.factors.blocks() {
            let own = self.factors.range(i);
            let n = own.len();
            let x = &mut blocks[own];
            let columns = self.factors.coupling(i).chunks_exact(n);
            for (column, t) in columns.zip(&solution.unknowns) {
                for (x, z) in x.iter_mut().zip(column) {
                    *x -= z * t;
                }
            }
        }
        let starts = (0..self.factors.blocks()).map(|i| self.factors.range(i).start);
        let correction = Correction {
            shared: solution.unknowns[..self.reduced.shared()].to_vec(),
            starts: starts.chain([blocks.len()]).collect(),
            blocks,
        };
        Ok(Solved {
            correction,
            squares: self.reduced.squares(),
            predicted_decrease: solution.decrease,
            covariance: Covariance::new(self.factors, &solution),
        })
    }
}
