//! The elimination of eight blocks: their normal equations, Cholesky factor, and Schur complement.

use std::ops::Range;

use super::{BLOCK_RANK_TOL, BlockBatch, QUAD, Shape};
use crate::error::Error;
use crate::lane_sums::LaneSums;
use crate::lanes::{LANES, Lanes, add_several_times, add_times, multiply, zeros};

/// A combination of columns that is too short.
struct WeakPivot {
    lane: usize,
    column: usize,
    /// What is left of it, relative to its length. NaN if a row is not finite.
    pivot: f64,
}

impl WeakPivot {
    /// The first lane of a column with no slack.
    #[cold]
    fn new(column: usize, slack: Lanes, left: Lanes, whole: Lanes) -> Self {
        let has_slack = |lane: usize| slack.0[lane] > 0.0;
        let lane = (0..LANES).find(|&lane| !has_slack(lane)).unwrap_or(0);
        let (left, whole) = (left.0[lane], whole.0[lane]);
        let pivot = match left.is_nan() {
            true => f64::NAN,
            false if whole > 0.0 => (left / whole).max(0.0).sqrt(),
            false => 0.0,
        };
        Self {
            lane,
            column,
            pivot,
        }
    }
}

impl BlockBatch {
    /// Eliminates the blocks' own unknowns: makes `[R | W | c | W_H]`. `number` gives the number of the block in a lane and the
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
                Ok(()) => return Ok(()),
                Err(weak) => weak,
            }
        };
        Err(self.error(&weak, &number))
    }

    /// Ranges of rows whose products are added together: three of one quad, a visit of three lengths, or one.
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

    /// `[AᵀA | AᵀB | Aᵀr | H]`.
    #[inline(always)]
    fn multiply(&mut self) {
        let Shape {
            unknowns,
            shared,
            datum,
            ..
        } = self.shape;
        let (length, system_len) = (self.shape.row_len(), self.shape.system_len());
        zeros(&mut self.system, unknowns * system_len);
        for range in Self::together(&self.starts) {
            let start = self.starts[range.start];
            let rows = &self.rows[range.start * length..range.end * length];
            match range.len() {
                1 => add_products(&self.shape, start, [rows], &mut self.system),
                _ => add_products(&self.shape, start, three(rows, length), &mut self.system),
            }
        }
        for k in 0..datum {
            let column = self.datum[k * unknowns..(k + 1) * unknowns].iter();
            for (x, row) in column.zip(self.system.chunks_exact_mut(system_len)) {
                row[unknowns + shared + 1 + k] = *x;
            }
        }
    }

    /// `AᵀA = RᵀR`, `[W | c | W_H] = R⁻ᵀ [AᵀB | Aᵀr | H]`.
    #[inline(always)]
    fn factorise(&mut self) -> Result<(), WeakPivot> {
        let length = self.shape.system_len();
        let limit = Lanes::splat(BLOCK_RANK_TOL * BLOCK_RANK_TOL);
        for k in 0..self.shape.unknowns {
            let (above, below) = self.system.split_at_mut(k * length);
            let row = &mut below[k..length];
            let whole = row[0];
            let mut threes = above.chunks_exact(3 * length);
            for rows in &mut threes {
                let rows = three(rows, length).map(|row| &row[k..]);
                add_several_times(row, rows.map(|row| -row[0]), rows);
            }
            for before in threes.remainder().chunks_exact(length) {
                add_times(row, -before[k], &before[k..]);
            }
            let slack = row[0] - limit * whole;
            // Not a number is no slack, too.
            let mut is_weak = false;
            for slack in slack.0 {
                is_weak |= slack.is_nan() | (slack <= 0.0);
            }
            if is_weak {
                return Err(WeakPivot::new(k, slack, row[0], whole));
            }
            let reciprocal = Lanes::splat(1.0) / row[0].sqrt();
            row[0] = reciprocal;
            multiply(&mut row[1..], reciprocal);
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

    /// Adds the eliminated blocks to the sums of the reduced system.
    #[inline(always)]
    pub fn add_to(&self, sums: &mut LaneSums) {
        let Shape {
            unknowns, in_quads, ..
        } = self.shape;
        let length = self.shape.row_len();
        for range in Self::together(&self.starts) {
            let start = (in_quads > 0).then_some(self.starts[range.start]);
            let rows = &self.rows[range.start * length..range.end * length];
            match range.len() {
                1 => sums.add_rows((start, in_quads), [&rows[unknowns..]]),
                _ => {
                    let rows = three(rows, length).map(|row| &row[unknowns..]);
                    sums.add_rows((start, in_quads), rows);
                }
            }
        }
        for (k, closure) in self.closure.iter().enumerate() {
            sums.add_to_closure(k, *closure);
        }
        sums.take_off_rows(&self.system, self.shape.system_len(), unknowns);
    }
}

/// Adds the products of some whitened rows `[A | quad | others | r]` of one quad to `[AᵀA | AᵀB | Aᵀr | H]`, of `AᵀA` to the
/// upper triangle.
#[inline(always)]
fn add_products<const N: usize>(
    shape: &Shape,
    start: usize,
    rows: [&[Lanes]; N],
    system: &mut [Lanes],
) {
    let &Shape {
        unknowns,
        in_quads,
        shared,
        ..
    } = shape;
    for (k, sums) in system.chunks_exact_mut(shape.system_len()).enumerate() {
        let factors = rows.map(|row| row[k]);
        let (own, sums) = sums.split_at_mut(unknowns);
        add_several_times(&mut own[k..], factors, rows.map(|row| &row[k..]));
        let tails = rows.map(|row| &row[unknowns..]);
        if in_quads > 0 {
            add_several_times(&mut sums[start..start + QUAD], factors, tails);
        }
        let tails = tails.map(|tail| &tail[QUAD..]);
        add_several_times(&mut sums[in_quads..=shared], factors, tails);
    }
}

/// Three rows that stand one after the other.
#[inline(always)]
fn three(rows: &[Lanes], length: usize) -> [&[Lanes]; 3] {
    let ((a, rest), c) = (rows.split_at(length), &rows[2 * length..]);
    [a, &rest[..length], c]
}
