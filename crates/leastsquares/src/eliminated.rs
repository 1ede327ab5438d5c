//! One block's normal equations, and what is left of them when the block is eliminated.
//!
//! With the block's whitened rows `[A | B | r]` and its part `H` of the datum, the normal equations
//! are reduced in place to triangular form:
//!
//! ```text
//! [ AᵀA | AᵀB  H  Aᵀr ]  ->  [ R | C  W  c ]        RᵀR = AᵀA    W = R⁻ᵀH
//! ```
//!
//! so that `R x + C s + W λ = c`. Forming `AᵀA` squares the condition: the relative error of `R` is
//! `ε / pivot²`, where a pivot is what is left of a column after those before it, relative to its
//! length. Cholesky is used as long as pivots exceed [`WEAK_PIVOT`], which costs six of sixteen
//! digits at the worst; blocks with weaker ones, down to where they count as free, are
//! [eliminated by reflections](Block::eliminate_rows) of their rows, which costs a digit for each
//! digit of the pivot only.

use crate::block::BlockRows;
use crate::error::Error;

/// A block under elimination; memory that is used again for one block after the other.
#[derive(Debug, Clone)]
pub struct Block {
    shared: usize,
    /// Shared unknowns, datum multipliers, and the right side.
    width: usize,
    unknowns: usize,
    /// `AᵀA`, then `R`: rows contiguous, upper triangle.
    own: Vec<f64>,
    /// `[AᵀB | H | Aᵀr]`, then `[C | W | c]`: rows contiguous.
    others: Vec<f64>,
    /// Squared lengths of the columns of `A`.
    lengths: Vec<f64>,
}

/// The least pivot that normal equations resolve well enough: see the module page.
const WEAK_PIVOT: f64 = 1e-3;

/// A pivot too weak for normal equations; the rows themselves may still resolve it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WeakPivot;

impl Block {
    /// Memory for the blocks of a system with `shared` shared unknowns and `datum` constraints.
    pub fn new(shared: usize, datum: usize) -> Self {
        Self {
            shared,
            width: shared + datum + 1,
            unknowns: 0,
            own: Vec::new(),
            others: Vec::new(),
            lengths: Vec::new(),
        }
    }

    /// Makes these the zero equations of a block of so many unknowns.
    pub fn reset(&mut self, unknowns: usize) {
        self.unknowns = unknowns;
        for (memory, size) in [
            (&mut self.own, unknowns * unknowns),
            (&mut self.others, unknowns * self.width),
            (&mut self.lengths, unknowns),
        ] {
            memory.clear();
            memory.resize(size, 0.0);
        }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Shared unknowns, datum multipliers, and the right side.
    pub(crate) fn width(&self) -> usize {
        self.width
    }

    /// Row `i` of `AᵀA`; what is left of the diagonal is not read.
    #[inline(always)]
    pub fn own_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.own[i * self.unknowns..][..self.unknowns]
    }

    /// Row `i` of `[AᵀB | H | Aᵀr]`.
    #[inline(always)]
    pub fn others_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.others[i * self.width..][..self.width]
    }

    /// Rows of `[C | W | c]`.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[f64] {
        &self.others
    }

    /// Eliminates the block by Cholesky.
    ///
    /// # Errors
    /// [`WeakPivot`], also for what is not finite; what the block holds is then of no use.
    #[inline(always)]
    pub fn eliminate(&mut self) -> Result<(), WeakPivot> {
        let (n, width) = (self.unknowns, self.width);
        for k in 0..n {
            self.lengths[k] = self.own[k * n + k];
        }
        for k in 0..n {
            let (own_head, own_tail) = self.own.split_at_mut((k + 1) * n);
            let (others_head, others_tail) = self.others.split_at_mut((k + 1) * width);
            let (own, others) = (&mut own_head[k * n..], &mut others_head[k * width..]);
            let left = own[k];
            // What is not a number is not greater either.
            let resolved = left > WEAK_PIVOT * WEAK_PIVOT * self.lengths[k];
            if !resolved {
                return Err(WeakPivot);
            }
            let scale = 1.0 / left.sqrt();
            own[k..].iter_mut().for_each(|x| *x *= scale);
            others.iter_mut().for_each(|x| *x *= scale);
            let below = own_tail.chunks_exact_mut(n);
            for (i, (own_below, others_below)) in
                (k + 1..n).zip(below.zip(others_tail.chunks_exact_mut(width)))
            {
                let factor = own[i];
                subtract(&mut own_below[i..], factor, &own[i..]);
                subtract(others_below, factor, others);
            }
        }
        Ok(())
    }

    /// Eliminates the block by reflections of its rows, which are used up. `datum` is `H`: one
    /// column of the block's size for each constraint, columns contiguous.
    ///
    /// # Errors
    /// [`Error::TooFewRows`], [`Error::BlockRank`], [`Error::NotFinite`] with the block's `number`.
    pub fn eliminate_rows(
        &mut self,
        number: usize,
        rows: &mut BlockRows,
        datum: &[f64],
    ) -> Result<(), Error> {
        rows.triangularise(number)?;
        let n = rows.block_unknowns();
        self.reset(n);
        let (shared, width) = (self.shared, self.width);
        for i in 0..n {
            for k in i..n {
                self.own[i * n + k] = rows.column(k)[i];
            }
            let others = &mut self.others[i * width..(i + 1) * width];
            for (k, value) in others[..shared].iter_mut().enumerate() {
                *value = rows.column(n + k)[i];
            }
            others[width - 1] = rows.column(n + shared)[i];
        }
        // W = R⁻ᵀH by forward substitution.
        for (column, h) in datum.chunks_exact(n).enumerate() {
            for (i, h) in h.iter().enumerate() {
                let before: f64 = (0..i)
                    .map(|k| self.own[k * n + i] * self.others[k * width + shared + column])
                    .sum();
                self.others[i * width + shared + column] = (h - before) / self.own[i * n + i];
            }
        }
        Ok(())
    }

    /// The correction `x = R⁻¹ (c - C s - W λ)` to the block's unknowns that belongs to one of the
    /// shared unknowns and multipliers `t = (s, λ)`.
    #[inline(always)]
    pub fn correction(&self, t: &[f64], x: &mut [f64]) {
        for (x, row) in x.iter_mut().zip(self.others.chunks_exact(self.width)) {
            let (taken, right) = (&row[..t.len()], row[self.width - 1]);
            *x = right - taken.iter().zip(t).map(|(y, t)| y * t).sum::<f64>();
        }
        self.substitute_back(x);
    }

    /// `x <- R⁻¹ x`.
    #[inline(always)]
    fn substitute_back(&self, x: &mut [f64]) {
        let n = self.unknowns;
        for i in (0..n).rev() {
            let row = &self.own[i * n..(i + 1) * n];
            let behind: f64 = row[i + 1..]
                .iter()
                .zip(&x[i + 1..n])
                .map(|(r, x)| r * x)
                .sum();
            x[i] = (x[i] - behind) / row[i];
        }
    }

    /// Writes `R⁻¹` and `Z = R⁻¹ [C | W]`, columns contiguous.
    pub(crate) fn write_factors(&self, inverse_factor: &mut [f64], coupling: &mut [f64]) {
        let n = self.unknowns;
        for (k, column) in inverse_factor.chunks_exact_mut(n).enumerate() {
            column.fill(0.0);
            column[k] = 1.0;
            self.substitute_back(column);
        }
        for (k, column) in coupling.chunks_exact_mut(n).enumerate() {
            for (i, x) in column.iter_mut().enumerate() {
                *x = self.others[i * self.width + k];
            }
            self.substitute_back(column);
        }
    }
}

/// `row -= factor · other`.
#[inline(always)]
fn subtract(row: &mut [f64], factor: f64, other: &[f64]) {
    for (x, y) in row.iter_mut().zip(other) {
        *x -= factor * y;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both ways to eliminate the same rows, one of whose pivots is `pivot`.
    fn both(pivot: f64) -> [Result<Block, ()>; 2] {
        let own = [
            [1.0, 0.5, -2.0, 0.3],
            [1.0, 0.5 + pivot, -2.0 - pivot, 0.3 + 2.0 * pivot],
        ];
        let shared = [0.2, 0.8, -0.4, 1.0];
        let residual = [0.1, -0.3, 0.7, 0.2];
        let datum = [0.6, -0.9];
        let mut rows = BlockRows::new(4, 2, 1);
        rows.block_mut(0).copy_from_slice(&own[0]);
        rows.block_mut(1).copy_from_slice(&own[1]);
        rows.shared_mut(0).copy_from_slice(&shared);
        rows.residual_mut().copy_from_slice(&residual);
        let mut reflected = Block::new(1, 1);
        let reflected = reflected
            .eliminate_rows(0, &mut rows, &datum)
            .map(|()| reflected)
            .map_err(|_| ());

        let dot = |a: &[f64; 4], b: &[f64; 4]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut normal = Block::new(1, 1);
        normal.reset(2);
        for i in 0..2 {
            for k in 0..2 {
                normal.own_mut(i)[k] = dot(&own[i], &own[k]);
            }
            let others = [dot(&own[i], &shared), datum[i], dot(&own[i], &residual)];
            normal.others_mut(i).copy_from_slice(&others);
        }
        let normal = normal.eliminate().map(|()| normal).map_err(|_| ());
        [normal, reflected]
    }

    #[test]
    fn normal_equations_and_reflections_agree() {
        for pivot in [1.0, 0.1, 0.01] {
            let [Ok(normal), Ok(reflected)] = both(pivot) else {
                panic!("pivot {pivot} is good");
            };
            // A correction is free of the signs of the reflected rows.
            let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
            normal.correction(&[0.3, -0.2], &mut x);
            reflected.correction(&[0.3, -0.2], &mut y);
            // The multiplier's part of a correction grows like 1 / pivot², its error once more.
            let tol = 1e-14 / pivot.powi(4);
            assert!(
                (x[0] - y[0]).abs() < tol && (x[1] - y[1]).abs() < tol,
                "{x:?} {y:?}"
            );
        }
    }

    #[test]
    fn a_weak_pivot_is_left_to_reflections_and_a_free_one_refused() {
        assert!(matches!(both(1e-4), [Err(()), Ok(_)]));
        assert!(matches!(both(1e-8), [Err(()), Err(())]));
    }
}
