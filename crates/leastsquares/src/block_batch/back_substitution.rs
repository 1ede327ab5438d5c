//! What follows for the unknowns of eight blocks from those of the reduced system: corrections and factors.

use std::ops::Range;

use super::{BlockBatch, RUN, Shape};
use crate::factors::Factors;
use crate::lanes::{Lanes, add_times, lanes_only, scale, zeros};

impl BlockBatch {
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

    /// Numbers that [`BlockBatch::keep`] writes for blocks with `unknowns` unknowns.
    pub fn kept_len(unknowns: usize) -> usize {
        unknowns * (unknowns + 1) / 2
    }

    /// Writes what [`BlockBatch::correction`] needs of the eliminated blocks: the rows of `R` from their
    /// diagonal on. Rows are made again for it, which costs less than to keep them.
    #[inline(always)]
    pub fn keep(&self, kept: &mut [Lanes]) {
        let n = self.shape.unknowns;
        let mut kept = kept;
        for (k, row) in self.factor.chunks_exact(n).enumerate() {
            let own;
            (own, kept) = kept.split_at_mut(n - k);
            own.copy_from_slice(&row[k..]);
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

    /// Appends the factors `R⁻¹` and `Z = R⁻¹ [W | W_H]` of the blocks, which have these numbers; they are eliminated, and
    /// nothing but their rows is left of them.
    #[inline(always)]
    pub fn add_factors(&mut self, blocks: Range<usize>, factors: &mut Factors) {
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
        let numbers = factors.begin(blocks, unknowns);
        for k in 0..unknowns {
            zeros(&mut self.own_column, unknowns);
            self.own_column[k] = Lanes::splat(1.0);
            Self::solve(&self.factor, &mut self.own_column);
            numbers.extend_from_slice(&self.own_column);
        }
        for row in self.coupling.chunks_exact(width) {
            numbers.extend_from_slice(&row[..width - 1]);
        }
    }
}
