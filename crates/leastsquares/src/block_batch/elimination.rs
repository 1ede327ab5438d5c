//! The elimination of eight blocks: their normal equations, Cholesky factor, and Schur complement.

use std::ops::Range;

use super::{BLOCK_RANK_TOL, BlockBatch, RUN, Shape};
use crate::error::Error;
use crate::lane_sums::LaneSums;
use crate::lanes::{LANES, Lanes, add_several_times, add_times, scale, zeros};

/// A combination of columns that is too short.
struct WeakPivot {
    lane: usize,
    column: usize,
    /// What is left of it, relative to its length. NaN if a row is not finite.
    pivot: f64,
}

impl BlockBatch {
    /// Eliminates the blocks' own unknowns: makes `R` and `[W | W_H | c]`. `number` gives the number of the block in a lane and the
    /// rows that it really has.
    ///
    /// # Errors
    /// [`Error::TooFewRows`], [`Error::BlockRank`], [`Error::NotFinite`].
    #[inline(always)]
    pub fn eliminate(&mut self, number: impl Fn(usize) -> (usize, usize)) -> Result<(), Error> {
        let weak = if self.shape.rows < self.shape.unknowns {
            WeakPivot {
                lane: 0,
                column: self.shape.rows,
                pivot: 0.0,
            }
        } else {
            self.multiply();
            match self.factorise() {
                Ok(()) => {
                    self.couple();
                    return Ok(());
                }
                Err(weak) => weak,
            }
        };
        Err(self.error(&weak, &number))
    }

    /// Ranges of rows whose products are added together: three of one run, a visit of three lengths, or one.
    #[inline(always)]
    fn together(starts: &[usize]) -> impl Iterator<Item = Range<usize>> {
        let mut first = 0;
        std::iter::from_fn(move || {
            let range = match starts.get(first..)? {
                [] => return None,
                [a, b, c, ..] if a == b && b == c => first..first + 3,
                _ => first..first + 1,
            };
            first = range.end;
            Some(range)
        })
    }

    /// `AᵀA` and `[AᵀB | H | Aᵀr]`.
    #[inline(always)]
    fn multiply(&mut self) {
        let Shape {
            unknowns,
            shared,
            datum,
            ..
        } = self.shape;
        let (length, width) = (self.shape.row_len(), self.shape.width());
        zeros(&mut self.factor, unknowns * unknowns);
        zeros(&mut self.coupling, unknowns * width);
        for range in Self::together(&self.starts) {
            let start = self.starts[range.start];
            let rows = &self.rows[range.start * length..range.end * length];
            let products = (&mut self.factor[..], &mut self.coupling[..]);
            match rows.len() / length {
                1 => add_products(&self.shape, start, [rows], products),
                _ => add_products(&self.shape, start, three(rows, length), products),
            }
        }
        for k in 0..datum {
            let column = self.datum[k * unknowns..(k + 1) * unknowns].iter();
            for (x, row) in column.zip(self.coupling.chunks_exact_mut(width)) {
                row[shared + k] = *x;
            }
        }
    }

    /// `AᵀA = RᵀR`.
    #[inline(always)]
    fn factorise(&mut self) -> Result<(), WeakPivot> {
        let Shape { unknowns, .. } = self.shape;
        let limit = Lanes::splat(BLOCK_RANK_TOL * BLOCK_RANK_TOL);
        for k in 0..unknowns {
            let (above, below) = self.factor.split_at_mut(k * unknowns);
            let row = &mut below[k..unknowns];
            let whole = row[0];
            for before in above.chunks_exact(unknowns) {
                add_times(row, -before[k], &before[k..]);
            }
            let slack = row[0] - limit * whole;
            // Not a number is no slack, too.
            let is_weak = |slack: f64| slack <= 0.0 || slack.is_nan();
            if let Some(lane) = (0..LANES).find(|&lane| is_weak(slack.0[lane])) {
                let (left, whole) = (row[0].0[lane], whole.0[lane]);
                let pivot = match left.is_nan() {
                    true => f64::NAN,
                    false if whole > 0.0 => (left / whole).max(0.0).sqrt(),
                    false => 0.0,
                };
                return Err(WeakPivot {
                    lane,
                    column: k,
                    pivot,
                });
            }
            let reciprocal = Lanes::splat(1.0) / row[0].sqrt();
            row[0] = reciprocal;
            scale(&mut row[1..], reciprocal);
        }
        Ok(())
    }

    #[cold]
    fn error(&self, weak: &WeakPivot, number: &dyn Fn(usize) -> (usize, usize)) -> Error {
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

    /// `[W | W_H | c] = R⁻ᵀ [AᵀB | H | Aᵀr]`.
    #[inline(always)]
    fn couple(&mut self) {
        let Shape { unknowns, .. } = self.shape;
        let width = self.shape.width();
        for k in 0..unknowns {
            let (above, row) = self.coupling.split_at_mut(k * width);
            let row = &mut row[..width];
            let of_factor = |j: usize| -self.factor[j * unknowns + k];
            let mut threes = above.chunks_exact(3 * width);
            let mut j = 0;
            for rows in &mut threes {
                let factors = [of_factor(j), of_factor(j + 1), of_factor(j + 2)];
                add_several_times(row, factors, three(rows, width));
                j += 3;
            }
            for before in threes.remainder().chunks_exact(width) {
                add_times(row, of_factor(j), before);
                j += 1;
            }
            scale(row, self.factor[k * unknowns + k]);
        }
    }

    /// Adds the eliminated blocks to the sums of the reduced system.
    #[inline(always)]
    pub fn add_to(&self, sums: &mut LaneSums) {
        let Shape {
            shared, in_runs, ..
        } = self.shape;
        let (unknowns, length) = (self.shape.unknowns, self.shape.row_len());
        let has_runs = in_runs > 0;
        for range in Self::together(&self.starts) {
            let start = self.starts[range.start];
            let rows = &self.rows[range.start * length..range.end * length];
            let at = (has_runs, start, in_runs);
            match range.len() {
                1 => sums.add_rows(at, [&rows[unknowns..]]),
                _ => sums.add_rows(at, three(rows, length).map(|row| &row[unknowns..])),
            }
        }
        for (k, closure) in self.closure.iter().enumerate() {
            sums.add_to_closure(shared + k, *closure);
        }
        for row in self.coupling.chunks_exact(self.shape.width()) {
            sums.take_off_row(row);
        }
    }
}

/// Adds the products of some whitened rows `[A | run | others | r]` of one run to `AᵀA`, upper triangle, and to
/// `[AᵀB | H | Aᵀr]`.
#[inline(always)]
fn add_products<const N: usize>(
    shape: &Shape,
    start: usize,
    rows: [&[Lanes]; N],
    (factor, coupling): (&mut [Lanes], &mut [Lanes]),
) {
    let &Shape {
        unknowns,
        in_runs,
        shared,
        ..
    } = shape;
    let (width, others) = (shape.width(), shared - in_runs);
    let of_factor = factor.chunks_exact_mut(unknowns);
    for (k, (squares, sums)) in of_factor.zip(coupling.chunks_exact_mut(width)).enumerate() {
        let factors = rows.map(|row| row[k]);
        add_several_times(&mut squares[k..], factors, rows.map(|row| &row[k..]));
        let tails = rows.map(|row| &row[unknowns..]);
        if in_runs > 0 {
            add_several_times(&mut sums[start..start + RUN], factors, tails);
        }
        let tails = tails.map(|tail| &tail[RUN..]);
        add_several_times(&mut sums[in_runs..shared], factors, tails);
        let residuals = tails.map(|tail| &tail[others..]);
        add_several_times(&mut sums[width - 1..], factors, residuals);
    }
}

/// Three rows that stand one after the other.
#[inline(always)]
fn three(rows: &[Lanes], length: usize) -> [&[Lanes]; 3] {
    let ((a, rest), c) = (rows.split_at(length), &rows[2 * length..]);
    [a, &rest[..length], c]
}
