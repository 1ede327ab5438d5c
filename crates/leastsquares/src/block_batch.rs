//! Eight blocks of the same shape, linearised and eliminated side by side.
//!
//! A block's whitened rows are `[A | B | r]`. Few of the shared unknowns are in a row: a run of
//! [`RUN`] that stand side by side (a station), and columns behind all runs that any row may use.
//! With the Cholesky factor `AᵀA = RᵀR` and what ties the blocks to the rest,
//!
//! ```text
//! [W | W_H | c] = R⁻ᵀ [AᵀB | H | Aᵀr]
//! ```
//!
//! the block gives `[B | r]ᵀ [B | r] - [W | W_H | c]ᵀ [W | W_H | c]` to the reduced system
//! ([`crate::Reduced`]), its Schur complement, and its unknowns follow from those of the reduced system by
//! `x = R⁻¹ (c - W s - W_H λ)`. A square of a pivot of `R` is what is left of a column after those before it:
//! relative to the column it says whether an unknown is determined. All of it belongs into
//! [`crate::in_widest_registers`]; outside it is right, but slow.

use std::ops::Range;

use crate::error::Error;
use crate::factors::FactorsMut;
use crate::lane_sums::LaneSums;
use crate::lanes::{LANES, Lanes, add_several_times, add_times, lanes_only, scale, zeros};

/// Shared unknowns that stand side by side in a row.
pub const RUN: usize = 4;

/// What is left of a column after the columns before it, relative to its length, below which an
/// unknown counts as free: its uncertainty would be a million times that of a direct reading.
pub const BLOCK_RANK_TOL: f64 = 1e-6;

/// Eight blocks, and memory for their elimination.
#[derive(Debug, Clone, Default)]
pub struct BlockBatch {
    shape: Shape,
    /// The rows `[A | run | others | r]`, one after the other.
    rows: Vec<Lanes>,
    /// Where the run of each row starts.
    starts: Vec<usize>,
    /// Columns of `H`, contiguous.
    datum: Vec<Lanes>,
    closure: Vec<Lanes>,
    /// `R`, rows contiguous; of the diagonal the reciprocals.
    factor: Vec<Lanes>,
    /// `[W | W_H | c]`, rows contiguous.
    coupling: Vec<Lanes>,
    own_column: Vec<Lanes>,
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

impl Shape {
    /// Elements of a row: own unknowns, a run, the unknowns behind the runs, the residual.
    #[inline(always)]
    fn row_len(&self) -> usize {
        self.unknowns + RUN + (self.shared - self.in_runs) + 1
    }

    /// Elements of a row of `[W | W_H | c]`.
    #[inline(always)]
    fn width(&self) -> usize {
        self.shared + self.datum + 1
    }
}

/// A row of eight blocks, to be filled.
#[derive(Debug)]
pub struct RowMut<'a> {
    /// Derivatives of the observation by the blocks' own unknowns.
    pub own: &'a mut [Lanes],
    /// The first shared unknown of the run.
    pub start: &'a mut usize,
    /// Derivatives by those of the run.
    pub run: &'a mut [Lanes],
    /// Derivatives by the shared unknowns behind the runs.
    pub others: &'a mut [Lanes],
    /// Observed minus computed.
    pub residual: &'a mut Lanes,
}

/// A combination of columns that is too short.
struct WeakPivot {
    lane: usize,
    column: usize,
    /// What is left of it, relative to its length. NaN if a row is not finite.
    pivot: f64,
}

impl BlockBatch {
    /// Makes these zero blocks of another shape; keeps the memory.
    #[inline(always)]
    pub fn reset(&mut self, shape: Shape) {
        self.shape = shape;
        zeros(&mut self.rows, shape.rows * shape.row_len());
        zeros(&mut self.starts, shape.rows);
        zeros(&mut self.datum, shape.unknowns * shape.datum);
        zeros(&mut self.closure, shape.datum);
    }

    /// The sizes.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// A row, to be filled.
    #[inline(always)]
    pub fn row_mut(&mut self, row: usize) -> RowMut<'_> {
        let length = self.shape.row_len();
        let (own, rest) = self.rows[row * length..][..length].split_at_mut(self.shape.unknowns);
        let (run, rest) = rest.split_at_mut(RUN);
        let (others, residual) = rest.split_at_mut(self.shape.shared - self.shape.in_runs);
        RowMut {
            own,
            start: &mut self.starts[row],
            run,
            others,
            residual: &mut residual[0],
        }
    }

    /// Multiplies the rows from `first` on from the left by a lower triangle, its rows one after the other.
    #[inline(always)]
    pub fn whiten(&mut self, first: usize, count: usize, triangle: &[Lanes]) {
        let length = self.shape.row_len();
        let rows = &mut self.rows[first * length..][..count * length];
        // From below: each row needs those above it as they were.
        for i in (0..count).rev() {
            let weights = &triangle[i * (i + 1) / 2..][..=i];
            let (above, row) = rows.split_at_mut(i * length);
            let row = &mut row[..length];
            scale(row, weights[i]);
            match (above.len() / length, weights) {
                (2, &[a, b, _]) => {
                    let above = above.split_at(length);
                    add_several_times(row, [a, b], [above.0, above.1]);
                }
                _ => {
                    for (above, w) in above.chunks_exact(length).zip(weights) {
                        add_times(row, *w, above);
                    }
                }
            }
        }
    }

    /// The rows of `A`, the shared unknowns' elements and the residual.
    #[inline(always)]
    fn parts(&self, row: usize) -> (&[Lanes], &[Lanes], &[Lanes], Lanes) {
        let length = self.shape.row_len();
        let (own, rest) = self.rows[row * length..][..length].split_at(self.shape.unknowns);
        let (run, rest) = rest.split_at(RUN);
        let (others, residual) = rest.split_at(rest.len() - 1);
        (own, run, others, residual[0])
    }

    /// The derivatives of a row by the blocks' own unknowns.
    #[inline(always)]
    pub fn own_row(&self, row: usize) -> &[Lanes] {
        self.parts(row).0
    }

    /// The residual of a row, observed minus computed.
    #[inline(always)]
    pub fn residual(&self, row: usize) -> Lanes {
        self.parts(row).3
    }

    /// Writes the shared unknowns' elements of a row to the front of `place`, which is zero.
    #[inline(always)]
    pub fn copy_shared_row(&self, row: usize, place: &mut [Lanes]) {
        let Shape { in_runs, .. } = self.shape;
        let (_, run, others, _) = self.parts(row);
        if in_runs > 0 {
            place[self.starts[row]..][..RUN].copy_from_slice(run);
        }
        place[in_runs..][..others.len()].copy_from_slice(others);
    }

    /// Column `k` of `H`, to be filled.
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

    /// Makes the lanes from `used` on count for nothing; their own columns stay as they are.
    #[inline(always)]
    pub fn use_only(&mut self, used: usize) {
        if used == LANES {
            return;
        }
        let mask = Lanes::from_fn(|lane| f64::from(u8::from(lane < used)));
        let (length, unknowns) = (self.shape.row_len(), self.shape.unknowns);
        for row in self.rows.chunks_exact_mut(length) {
            for x in &mut row[unknowns..] {
                *x = *x * mask;
            }
        }
        for x in self.datum.iter_mut().chain(&mut self.closure) {
            *x = *x * mask;
        }
    }

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
                _ => {
                    let ((a, rest), c) = (rows.split_at(length), &rows[2 * length..]);
                    add_products(&self.shape, start, [a, &rest[..length], c], products);
                }
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
            for three in &mut threes {
                let ((a, rest), c) = (three.split_at(width), &three[2 * width..]);
                let factors = [of_factor(j), of_factor(j + 1), of_factor(j + 2)];
                add_several_times(row, factors, [a, &rest[..width], c]);
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
            let row =
                |k: usize| &self.rows[(range.start + k) * length + unknowns..][..length - unknowns];
            match range.len() {
                1 => sums.add_rows((has_runs, start, in_runs), [row(0)]),
                _ => sums.add_rows((has_runs, start, in_runs), [row(0), row(1), row(2)]),
            }
        }
        for (k, closure) in self.closure.iter().enumerate() {
            sums.add_to_closure(shared + k, *closure);
        }
        for row in self.coupling.chunks_exact(self.shape.width()) {
            sums.take_off_row(row);
        }
    }

    /// `x <- R⁻¹ x`.
    #[inline(always)]
    fn solve(factor: &[Lanes], x: &mut [Lanes]) {
        let n = x.len();
        for k in (0..n).rev() {
            let mut sum = x[k];
            for (r, x) in factor[k * n + k + 1..(k + 1) * n].iter().zip(&x[k + 1..]) {
                lanes_only();
                sum = r.mul_add(-*x, sum);
            }
            x[k] = sum * factor[k * n + k];
        }
    }

    /// Numbers that [`BlockBatch::keep`] writes, for blocks of so many unknowns.
    pub fn kept_len(unknowns: usize) -> usize {
        unknowns * (unknowns + 1) / 2
    }

    /// Appends what [`BlockBatch::correction`] needs of the eliminated blocks: the rows of `R` from their
    /// diagonal on. Rows are made again for it, which costs less than to keep them.
    #[inline(always)]
    pub fn keep(&self, kept: &mut Vec<Lanes>) {
        let n = self.shape.unknowns;
        for (k, row) in self.factor.chunks_exact(n).enumerate() {
            kept.extend_from_slice(&row[k..]);
        }
    }

    /// Takes what the shared unknowns `s` explain off the residuals: `r - B s`.
    #[inline(always)]
    pub fn take_off(&mut self, s: &[f64]) {
        let Shape {
            unknowns, in_runs, ..
        } = self.shape;
        let length = self.shape.row_len();
        for (row, &start) in self.rows.chunks_exact_mut(length).zip(&self.starts) {
            let (run, rest) = row[unknowns..].split_at(RUN);
            let (others, residual) = rest.split_at(rest.len() - 1);
            let mut left = residual[0];
            if in_runs > 0 {
                for (b, s) in run.iter().zip(&s[start..]) {
                    lanes_only();
                    left = b.mul_add(Lanes::splat(-*s), left);
                }
            }
            for (b, s) in others.iter().zip(&s[in_runs..]) {
                lanes_only();
                left = b.mul_add(Lanes::splat(-*s), left);
            }
            row[length - 1] = left;
        }
    }

    /// Multiplies the residuals of the rows from `first` on by `LᵀL` of a lower triangle `L`, its rows one after
    /// the other: what [`BlockBatch::whiten`] would do to both sides of their products.
    #[inline(always)]
    pub fn weigh(&mut self, first: usize, count: usize, triangle: &[Lanes]) {
        let length = self.shape.row_len();
        let rows = &mut self.rows[first * length..][..count * length];
        for i in (0..count).rev() {
            let weights = &triangle[i * (i + 1) / 2..][..=i];
            let mut whitened = Lanes::ZERO;
            for (row, w) in rows.chunks_exact(length).zip(weights) {
                lanes_only();
                whitened = w.mul_add(row[length - 1], whitened);
            }
            // Rows above keep theirs until they have been whitened: this one is needed no more.
            rows[i * length + length - 1] = whitened;
        }
        for j in 0..count {
            let mut weighed = Lanes::ZERO;
            for (i, row) in rows.chunks_exact(length).enumerate().skip(j) {
                lanes_only();
                weighed = triangle[i * (i + 1) / 2 + j].mul_add(row[length - 1], weighed);
            }
            rows[j * length + length - 1] = weighed;
        }
    }

    /// The corrections `x = R⁻¹ R⁻ᵀ Aᵀ y` to the blocks' unknowns, for the weighed residuals `y` that the shared
    /// unknowns leave and `R` as it was kept: without a datum, or with one that fixes no more than the motions
    /// that are free, the multipliers of which are zero.
    #[inline(always)]
    pub fn correction(&mut self, kept: &[Lanes]) -> &[Lanes] {
        let n = self.shape.unknowns;
        let length = self.shape.row_len();
        zeros(&mut self.factor, n * n);
        let mut kept = kept;
        for (k, row) in self.factor.chunks_exact_mut(n).enumerate() {
            let own;
            (own, kept) = kept.split_at(n - k);
            row[k..].copy_from_slice(own);
        }
        zeros(&mut self.own_column, n);
        for row in self.rows.chunks_exact(length) {
            add_times(&mut self.own_column, row[length - 1], &row[..n]);
        }
        // R⁻ᵀ, then R⁻¹.
        for k in 0..n {
            let x = self.own_column[k] * self.factor[k * n + k];
            self.own_column[k] = x;
            add_times(
                &mut self.own_column[k + 1..],
                -x,
                &self.factor[k * n + k + 1..(k + 1) * n],
            );
        }
        Self::solve(&self.factor, &mut self.own_column);
        &self.own_column
    }

    /// Writes the factors `R⁻¹` and `Z = R⁻¹ [W | W_H]` of the first `used` blocks, numbered from `first`; the
    /// blocks are eliminated, and nothing but their rows is left of them.
    #[inline(always)]
    pub fn write_factors(&mut self, first: usize, used: usize, factors: &mut FactorsMut<'_>) {
        let Shape { unknowns, .. } = self.shape;
        let width = self.shape.width();
        // Z, from the last row up.
        for k in (0..unknowns).rev() {
            let (row, below) = self.coupling[k * width..].split_at_mut(width);
            let of_factor = &self.factor[k * unknowns..(k + 1) * unknowns];
            for (r, other) in of_factor[k + 1..].iter().zip(below.chunks_exact(width)) {
                add_times(row, -*r, other);
            }
            scale(row, of_factor[k]);
        }
        for k in 0..unknowns {
            zeros(&mut self.own_column, unknowns);
            self.own_column[k] = Lanes::splat(1.0);
            Self::solve(&self.factor, &mut self.own_column);
            for lane in 0..used {
                let (inverse_factor, _) = factors.block_mut(first + lane);
                let column = &mut inverse_factor[k * unknowns..(k + 1) * unknowns];
                for (x, lanes) in column.iter_mut().zip(&self.own_column) {
                    *x = lanes.0[lane];
                }
            }
        }
        for lane in 0..used {
            let (_, coupling) = factors.block_mut(first + lane);
            let rows = coupling.chunks_exact_mut(width - 1);
            for (row, lanes) in rows.zip(self.coupling.chunks_exact(width)) {
                for (x, lanes) in row.iter_mut().zip(lanes) {
                    *x = lanes.0[lane];
                }
            }
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
