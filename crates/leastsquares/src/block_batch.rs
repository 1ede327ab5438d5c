//! Eight blocks of the same shape, linearised and eliminated side by side.
//!
//! A block's whitened rows are `[A | B | r]`. Few of the shared unknowns are in a row: a run of
//! [`RUN`] that stand side by side (a station), and columns behind all runs that any row may use.
//! With `A = Q [R; 0]` ([`crate::reflections`]) and the rows `Q₂ᵀ` of `Qᵀ` that are free of the block's
//! unknowns, the block gives to the reduced system ([`crate::Reduced`])
//!
//! ```text
//! M = Q₂ᵀ [B | r]       W = R⁻ᵀ H       c = Q₁ᵀ r
//!
//! (s, [s, 1]): MᵀM      (s, λ): -Bᵀ Q₁ W      (λ, [λ, 1]): -Wᵀ [W | c]
//! ```
//!
//! and its unknowns follow from those of the reduced system by `x = R⁻¹ (Q₁ᵀ (r - B s) - W λ)`. `MᵀM`
//! is a sum of squares: nothing cancels in it, so what is not determined stays visible.
//! ([`LaneSums`] has a shorter way for blocks of a kind, in which something may.) All of it belongs into
//! [`crate::in_widest_registers`]; outside it is right, but slow.

use crate::error::Error;
use crate::factors::FactorsMut;
use crate::lane_sums::LaneSums;
use crate::lanes::{LANES, Lanes, dot, lanes_only, zeros};
use crate::reflections::{BLOCK_RANK_TOL, Reflections, WeakPivot};

/// Shared unknowns that stand side by side in a row.
pub const RUN: usize = 4;

/// Eight blocks, and memory for their elimination.
#[derive(Debug, Clone, Default)]
pub struct BlockBatch {
    shape: Shape,
    own: Reflections,
    /// Where the run of each row starts.
    starts: Vec<usize>,
    runs: Vec<[Lanes; RUN]>,
    /// Columns behind the runs, contiguous.
    others: Vec<Lanes>,
    residual: Vec<Lanes>,
    /// Columns of `H`, contiguous.
    datum: Vec<Lanes>,
    closure: Vec<Lanes>,
    /// A column in the space of the rows.
    column: Vec<Lanes>,
    /// A column in the space of the blocks' unknowns.
    own_column: Vec<Lanes>,
    /// One element for each shared unknown.
    shared_row: Vec<Lanes>,
    /// `R⁻¹` and `Z`, columns contiguous, for [`BlockBatch::write_factors`].
    inverse_factor: Vec<Lanes>,
    coupling: Vec<Lanes>,
}

/// The sizes of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Shape {
    /// Rows of each block; a block with fewer has zeros in the others.
    pub rows: usize,
    /// Unknowns of each block.
    pub unknowns: usize,
    /// Shared unknowns in runs: they come first.
    pub in_runs: usize,
    /// All shared unknowns.
    pub shared: usize,
    /// Constraints of the datum.
    pub datum: usize,
}

impl BlockBatch {
    /// Makes these zero blocks of another shape; keeps the memory.
    #[inline(always)]
    pub fn reset(&mut self, shape: Shape) {
        self.shape = shape;
        self.own.reset(shape.rows, shape.unknowns);
        zeros(&mut self.residual, shape.rows);
        zeros(
            &mut self.others,
            shape.rows * (shape.shared - shape.in_runs),
        );
        zeros(&mut self.datum, shape.unknowns * shape.datum);
        zeros(&mut self.closure, shape.datum);
        self.starts.clear();
        self.runs.clear();
        if shape.in_runs > 0 {
            self.starts.resize(shape.rows, 0);
            self.runs.resize(shape.rows, [Lanes::ZERO; RUN]);
        }
    }

    /// The sizes.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Column of the blocks' own unknown `k`: derivative of the observations.
    #[inline(always)]
    pub fn own(&self, k: usize) -> &[Lanes] {
        self.own.column(k)
    }

    /// The same, to be filled.
    #[inline(always)]
    pub fn own_mut(&mut self, k: usize) -> &mut [Lanes] {
        self.own.column_mut(k)
    }

    /// The run of a row and the first shared unknown in it.
    ///
    /// # Panics
    /// If no shared unknowns are in runs.
    #[inline(always)]
    pub fn run_mut(&mut self, row: usize) -> (&mut usize, &mut [Lanes; RUN]) {
        (&mut self.starts[row], &mut self.runs[row])
    }

    /// Column of a shared unknown behind the runs.
    #[inline(always)]
    pub fn other_mut(&mut self, shared: usize) -> &mut [Lanes] {
        let (k, rows) = (shared - self.shape.in_runs, self.shape.rows);
        &mut self.others[k * rows..(k + 1) * rows]
    }

    /// The residuals, observed minus computed.
    #[inline(always)]
    pub fn residual_mut(&mut self) -> &mut [Lanes] {
        &mut self.residual
    }

    /// The same, to be read.
    #[inline(always)]
    pub(crate) fn residual(&self) -> &[Lanes] {
        &self.residual
    }

    /// Writes the shared unknowns' elements of a row to the front of `row`, which is zero.
    #[inline(always)]
    pub(crate) fn copy_shared_row(&self, i: usize, row: &mut [Lanes]) {
        let Shape { rows, in_runs, .. } = self.shape;
        if let Some(run) = self.runs.get(i) {
            row[self.starts[i]..self.starts[i] + RUN].copy_from_slice(run);
        }
        let others = self.others.chunks_exact(rows);
        for (place, column) in row[in_runs..].iter_mut().zip(others) {
            *place = column[i];
        }
    }

    /// Column `k` of `H`.
    #[inline(always)]
    pub fn datum(&self, k: usize) -> &[Lanes] {
        let n = self.shape.unknowns;
        &self.datum[k * n..(k + 1) * n]
    }

    /// The same, to be filled.
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

    /// Shared part, residuals and datum of other blocks: those whose own unknowns are tied to these.
    #[inline(always)]
    pub fn take_shared(&mut self, other: &Self) {
        self.starts.clone_from(&other.starts);
        self.runs.clone_from(&other.runs);
        self.residual.clone_from(&other.residual);
        self.closure.clone_from(&other.closure);
        let count = other.others.len();
        self.others[..count].copy_from_slice(&other.others);
    }

    /// Makes the lanes from `used` on count for nothing; their own columns stay as they are.
    #[inline(always)]
    pub fn use_only(&mut self, used: usize) {
        if used == LANES {
            return;
        }
        let mask = Lanes::from_fn(|lane| f64::from(u8::from(lane < used)));
        let all = self.runs.as_flattened_mut().iter_mut();
        let all = all.chain(&mut self.others).chain(&mut self.residual);
        for x in all.chain(&mut self.datum).chain(&mut self.closure) {
            *x = *x * mask;
        }
    }

    /// Eliminates the blocks' own unknowns. `number` gives the number of the block in a lane and the
    /// rows that it really has.
    ///
    /// # Errors
    /// [`Error::TooFewRows`], [`Error::BlockRank`], [`Error::NotFinite`].
    #[inline(always)]
    pub fn eliminate(&mut self, number: impl Fn(usize) -> (usize, usize)) -> Result<(), Error> {
        let unknowns = self.shape.unknowns;
        let weak = if self.shape.rows < unknowns {
            WeakPivot {
                lane: 0,
                column: self.shape.rows,
                pivot: 0.0,
            }
        } else {
            match self.own.eliminate() {
                Ok(()) => return Ok(()),
                Err(weak) => weak,
            }
        };
        Err(self.error(weak, &number))
    }

    #[cold]
    fn error(&self, weak: WeakPivot, number: &dyn Fn(usize) -> (usize, usize)) -> Error {
        let unknowns = self.shape.unknowns;
        // Of several lanes the first with too few rows: it explains a weak pivot.
        for lane in 0..LANES {
            let (block, rows) = number(lane);
            if rows < unknowns {
                return Error::TooFewRows {
                    block,
                    rows,
                    unknowns,
                };
            }
        }
        if weak.pivot.is_nan() {
            return Error::NotFinite {
                what: "a whitened row",
            };
        }
        Error::BlockRank {
            block: number(weak.lane).0,
            unknown: weak.column,
            pivot: weak.pivot,
            limit: BLOCK_RANK_TOL,
        }
    }

    /// Adds the eliminated blocks to the sums of the reduced system.
    #[inline(always)]
    pub fn add_to(&mut self, sums: &mut LaneSums) {
        sums.add_squares(dot(&self.residual, &self.residual));
        for row in self.shape.unknowns..self.shape.rows {
            self.fill_free_row(row, sums.next_row());
        }
        self.add_datum(sums);
    }

    /// Fills row `row - unknowns` of `M`, zeros before.
    #[inline(always)]
    fn fill_free_row(&mut self, row: usize, free_row: &mut [Lanes]) {
        let Shape { rows, shared, .. } = self.shape;
        zeros(&mut self.column, rows);
        self.column[row] = Lanes::splat(1.0);
        self.own.reflect_back(&mut self.column);
        self.add_times_shared(&mut free_row[..shared]);
        free_row[shared] = dot(&self.column, &self.residual);
    }

    /// Adds `qᵀ B` of the column `q` in the space of the rows.
    #[inline(always)]
    fn add_times_shared(&self, product: &mut [Lanes]) {
        let Shape { rows, in_runs, .. } = self.shape;
        let runs = self.runs.iter().zip(&self.starts);
        for (q, (run, &start)) in self.column.iter().zip(runs) {
            for (sum, b) in product[start..start + RUN].iter_mut().zip(run) {
                lanes_only();
                *sum = q.mul_add(*b, *sum);
            }
        }
        let others = self.others.chunks_exact(rows);
        for (sum, column) in product[in_runs..].iter_mut().zip(others) {
            *sum += dot(&self.column, column);
        }
    }

    /// Adds what the datum gives.
    #[inline(always)]
    fn add_datum(&mut self, sums: &mut LaneSums) {
        let Shape {
            rows,
            unknowns,
            shared,
            datum,
            ..
        } = self.shape;
        // H becomes W, the residuals' copy becomes c.
        for column in self.datum.chunks_exact_mut(unknowns) {
            self.own.solve_transposed(column);
        }
        self.column.clone_from(&self.residual);
        self.own.reflect(&mut self.column);
        let offset = &self.column[..unknowns];
        sums.add_taken(dot(offset, offset));
        for (k, weighted) in self.datum.chunks_exact(unknowns).enumerate() {
            sums.add_to_closure(k, self.closure[k] - dot(weighted, offset));
            let others = self.datum.chunks_exact(unknowns).enumerate();
            for (l, other) in others.skip(k) {
                sums.add_to_datum(k, l, dot(weighted, other));
            }
        }
        let mut product = std::mem::take(&mut self.shared_row);
        for k in 0..datum {
            zeros(&mut self.column, rows);
            let weighted = &self.datum[k * unknowns..(k + 1) * unknowns];
            self.column[..unknowns].copy_from_slice(weighted);
            self.own.reflect_back(&mut self.column);
            zeros(&mut product, shared);
            self.add_times_shared(&mut product);
            sums.add_to_border(k, &product);
        }
        self.shared_row = product;
    }

    /// The corrections to the blocks' unknowns that belong to the solution `t = (s, λ)` of the reduced
    /// system; the blocks are eliminated, and not yet added to sums.
    #[inline(always)]
    pub fn correction(&mut self, t: &[f64]) -> &[Lanes] {
        let Shape {
            rows,
            unknowns,
            in_runs,
            shared,
            ..
        } = self.shape;
        let (s, multipliers) = t.split_at(shared);
        self.column.clone_from(&self.residual);
        let runs = self.runs.iter().zip(&self.starts);
        for (r, (run, &start)) in self.column.iter_mut().zip(runs) {
            for (b, s) in run.iter().zip(&s[start..start + RUN]) {
                lanes_only();
                *r = b.mul_add(Lanes::splat(-*s), *r);
            }
        }
        for (column, s) in self.others.chunks_exact(rows).zip(&s[in_runs..]) {
            for (r, b) in self.column.iter_mut().zip(column) {
                lanes_only();
                *r = b.mul_add(Lanes::splat(-*s), *r);
            }
        }
        self.own.reflect(&mut self.column);
        if !multipliers.is_empty() {
            zeros(&mut self.own_column, unknowns);
            for (column, multiplier) in self.datum.chunks_exact(unknowns).zip(multipliers) {
                for (y, h) in self.own_column.iter_mut().zip(column) {
                    lanes_only();
                    *y = h.mul_add(Lanes::splat(*multiplier), *y);
                }
            }
            self.own.solve_transposed(&mut self.own_column);
            for (x, y) in self.column.iter_mut().zip(&self.own_column) {
                lanes_only();
                *x -= *y;
            }
        }
        self.own.solve(&mut self.column[..unknowns]);
        &self.column[..unknowns]
    }

    /// Writes the factors of the first `used` blocks, numbered from `first`; the blocks are eliminated,
    /// and not yet added to sums.
    #[inline(always)]
    pub fn write_factors(&mut self, first: usize, used: usize, factors: &mut FactorsMut<'_>) {
        let Shape {
            rows,
            unknowns,
            shared,
            datum,
            ..
        } = self.shape;
        zeros(&mut self.inverse_factor, unknowns * unknowns);
        zeros(&mut self.coupling, unknowns * (shared + datum));
        for (k, column) in self.inverse_factor.chunks_exact_mut(unknowns).enumerate() {
            column[k] = Lanes::splat(1.0);
            self.own.solve(column);
        }
        let mut product = std::mem::take(&mut self.shared_row);
        for k in 0..unknowns {
            // Row k of R⁻¹Q₁ᵀ.
            zeros(&mut self.column, rows);
            for (j, x) in self.column[..unknowns].iter_mut().enumerate().skip(k) {
                *x = self.inverse_factor[j * unknowns + k];
            }
            self.own.reflect_back(&mut self.column);
            zeros(&mut product, shared);
            self.add_times_shared(&mut product);
            for (column, x) in self.coupling.chunks_exact_mut(unknowns).zip(&product) {
                column[k] = *x;
            }
        }
        self.shared_row = product;
        let of_datum = &mut self.coupling[shared * unknowns..];
        of_datum.copy_from_slice(&self.datum);
        for column in of_datum.chunks_exact_mut(unknowns) {
            self.own.solve_transposed(column);
            self.own.solve(column);
        }
        for lane in 0..used {
            let (inverse_factor, coupling) = factors.block_mut(first + lane);
            for (x, lanes) in inverse_factor.iter_mut().zip(&self.inverse_factor) {
                *x = lanes.0[lane];
            }
            for (k, row) in coupling.chunks_exact_mut(shared + datum).enumerate() {
                let column = self.coupling[k..].iter().step_by(unknowns);
                for (x, lanes) in row.iter_mut().zip(column) {
                    *x = lanes.0[lane];
                }
            }
        }
    }
}
