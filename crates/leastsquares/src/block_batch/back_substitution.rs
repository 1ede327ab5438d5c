//! What follows for the unknowns of eight blocks from those of the reduced system: corrections and factors.

use std::ops::Range;

use super::{BlockBatch, QUAD, Shape};
use crate::factors::Factors;
use crate::lanes::{Lanes, add_times, lanes_only, multiply, zeros};

impl BlockBatch {
    /// Numbers that [`BlockBatch::keep`] writes for blocks with `unknowns` unknowns.
    pub fn kept_len(unknowns: usize) -> usize {
        unknowns * (unknowns + 1) / 2
    }

    /// Writes what [`BlockBatch::correction`] needs of the eliminated blocks: the rows of `R` from their
    /// diagonal on. Rows are made again for it, which costs less than to keep them.
    #[inline(always)]
    pub fn keep(&self, kept: &mut [Lanes]) {
        let (n, mut kept) = (self.shape.unknowns, kept);
        let rows = self.system.chunks_exact(self.shape.system_len());
        for (k, row) in rows.enumerate() {
            let own;
            (own, kept) = kept.split_at_mut(n - k);
            own.copy_from_slice(&row[k..n]);
        }
    }

    /// Takes what the shared unknowns `s` explain off the residuals: `r - B s`.
    #[inline(always)]
    pub fn take_off(&mut self, s: &[f64]) {
        let Shape {
            unknowns, in_quads, ..
        } = self.shape;
        let (length, residual) = (self.shape.row_len(), self.shape.residual());
        for (row, &start) in self.rows.chunks_exact_mut(length).zip(&self.starts) {
            let (quad, others) = row[unknowns..residual].split_at(QUAD);
            let mut left = row[residual];
            if in_quads > 0 {
                for (b, s) in quad.iter().zip(&s[start..]) {
                    lanes_only();
                    left = b.mul_add(Lanes::splat(-*s), left);
                }
            }
            for (b, s) in others.iter().zip(&s[in_quads..]) {
                lanes_only();
                left = b.mul_add(Lanes::splat(-*s), left);
            }
            row[residual] = left;
        }
    }

    /// Multiplies the residuals of the rows from `first` on by `LᵀL` of a lower triangle `L`, its rows one after
    /// the other: what [`BlockBatch::whiten`] would do to both sides of their products.
    #[inline(always)]
    pub fn weigh(&mut self, first: usize, count: usize, triangle: &[Lanes]) {
        let (length, residual) = (self.shape.row_len(), self.shape.residual());
        let rows = &mut self.rows[first * length..][..count * length];
        for i in (0..count).rev() {
            let weights = &triangle[i * (i + 1) / 2..][..=i];
            let mut whitened = Lanes::ZERO;
            for (row, w) in rows.chunks_exact(length).zip(weights) {
                lanes_only();
                whitened = w.mul_add(row[residual], whitened);
            }
            // Rows above keep theirs until they have been whitened: this one is needed no more.
            rows[i * length + residual] = whitened;
        }
        for j in 0..count {
            let mut weighed = Lanes::ZERO;
            for (i, row) in rows.chunks_exact(length).enumerate().skip(j) {
                lanes_only();
                weighed = triangle[i * (i + 1) / 2 + j].mul_add(row[residual], weighed);
            }
            rows[j * length + residual] = weighed;
        }
    }

    /// The corrections `x = R⁻¹ R⁻ᵀ Aᵀ y` to the blocks' unknowns, for the weighed residuals `y` that the shared
    /// unknowns leave and `R` as it was kept: without a datum, or with one that fixes no more than the motions
    /// that are free, the multipliers of which are zero.
    #[inline(always)]
    pub fn correction(&mut self, kept: &[Lanes]) -> &[Lanes] {
        let n = self.shape.unknowns;
        let (length, residual) = (self.shape.row_len(), self.shape.residual());
        zeros(&mut self.own_column, n);
        for row in self.rows.chunks_exact(length) {
            add_times(&mut self.own_column, row[residual], &row[..n]);
        }
        // R⁻ᵀ, then R⁻¹.
        let mut rest = kept;
        for k in 0..n {
            let row;
            (row, rest) = rest.split_at(n - k);
            let x = self.own_column[k] * row[0];
            self.own_column[k] = x;
            add_times(&mut self.own_column[k + 1..], -x, &row[1..]);
        }
        let mut rest = kept;
        for k in (0..n).rev() {
            let row;
            (rest, row) = rest.split_at(rest.len() - (n - k));
            let (x, known) = self.own_column[k..].split_at_mut(1);
            let mut left = x[0];
            for (r, x) in row[1..].iter().zip(known) {
                lanes_only();
                left = r.mul_add(-*x, left);
            }
            x[0] = left * row[0];
        }
        &self.own_column
    }

    /// Appends the factors `[R⁻¹ | Z] = R⁻¹ [1 | W | W_H]` of the blocks, which have these numbers; they are eliminated, and
    /// nothing but their rows is left of them.
    #[inline(always)]
    pub fn add_factors(&mut self, blocks: Range<usize>, factors: &mut Factors) {
        let Shape {
            unknowns: n,
            shared,
            datum,
            ..
        } = self.shape;
        let length = self.shape.system_len();
        // From the last row up; what is below the diagonal stays zero.
        for k in (0..n).rev() {
            let (row, below) = self.system[k * length..].split_at_mut(length);
            self.own_column.clear();
            self.own_column.extend_from_slice(&row[k..n]);
            row[..n].fill(Lanes::ZERO);
            row[k] = Lanes::splat(1.0);
            let others = below.chunks_exact(length).zip(&self.own_column[1..]);
            for (j, (other, r)) in (k + 1..).zip(others) {
                add_times(&mut row[j..], -*r, &other[j..]);
            }
            multiply(&mut row[k..], self.own_column[0]);
        }
        let numbers = factors.begin(blocks, n);
        let rows = || self.system.chunks_exact(length);
        rows().for_each(|row| numbers.extend_from_slice(&row[..n]));
        for row in rows() {
            let (of_shared, behind) = row[n..].split_at(shared);
            numbers.extend_from_slice(of_shared);
            numbers.extend_from_slice(&behind[1..=datum]);
        }
    }
}
