//! Orthogonal elimination of eight small matrices at once, by Householder reflections.
//!
//! `A = Q [R; 0]`, where `Q` is kept as its reflections `1 - β_k v_k v_kᵀ`. Reflections keep lengths and
//! never form `AᵀA`: what a column has left after those before it is known to a few units of the last
//! place, so that rank can be judged from it (G. Golub and C. Van Loan, *Matrix Computations*, 5.2).

use crate::lanes::{LANES, Lanes, dot, lanes_only};

/// What is left of a column after the columns before it, relative to its length, below which an
/// unknown counts as free: its uncertainty would be a million times that of a direct reading.
pub const BLOCK_RANK_TOL: f64 = 1e-6;

/// Eight matrices of the same shape, columns contiguous.
#[derive(Debug, Clone, Default)]
pub(crate) struct Reflections {
    rows: usize,
    columns: usize,
    /// The columns of `A`; after the elimination `R` above the diagonal, and the rest `v_k`.
    elements: Vec<Lanes>,
    /// Reciprocals of the diagonal of `R`.
    reciprocals: Vec<Lanes>,
    /// `β_k`.
    factors: Vec<Lanes>,
}

/// A column that hangs on those before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WeakPivot {
    pub(crate) lane: usize,
    pub(crate) column: usize,
    /// What is left of it, relative to its length. NaN if the matrix is not finite.
    pub(crate) pivot: f64,
}

impl Reflections {
    /// Makes these zero matrices of another shape; keeps the memory.
    #[inline(always)]
    pub(crate) fn reset(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        self.elements.clear();
        self.elements.resize(rows * columns, Lanes::ZERO);
        self.reciprocals.clear();
        self.factors.clear();
    }

    #[inline(always)]
    pub(crate) fn column(&self, k: usize) -> &[Lanes] {
        &self.elements[k * self.rows..(k + 1) * self.rows]
    }

    #[inline(always)]
    pub(crate) fn column_mut(&mut self, k: usize) -> &mut [Lanes] {
        &mut self.elements[k * self.rows..(k + 1) * self.rows]
    }

    /// Eliminates. There must be at least as many rows as columns.
    #[inline(always)]
    pub(crate) fn eliminate(&mut self) -> Result<(), WeakPivot> {
        let limit = Lanes::splat(BLOCK_RANK_TOL * BLOCK_RANK_TOL);
        for k in 0..self.columns {
            let (head, tail) = self.elements.split_at_mut((k + 1) * self.rows);
            let (above, v) = head[k * self.rows..].split_at_mut(k);
            let squares = dot(v, v);
            // Reflections keep lengths: the whole column still has its original one.
            let all = squares + dot(above, above);
            let slack = squares - limit * all;
            // Not a number is no slack, too.
            let is_weak = |slack: f64| slack <= 0.0 || slack.is_nan();
            if let Some(lane) = (0..LANES).find(|&lane| is_weak(slack.0[lane])) {
                let (left, all) = (squares.0[lane], all.0[lane]);
                let pivot = if all > 0.0 || all.is_nan() {
                    (left / all).sqrt()
                } else {
                    0.0
                };
                return Err(WeakPivot {
                    lane,
                    column: k,
                    pivot,
                });
            }
            // v = x + sign(x0) |x| e0, so that v·v / 2 = |x| (|x| + |x0|); |v0| = |x| + |x0|.
            let left = squares.sqrt();
            let head = left + v[0].abs();
            let factor = Lanes::splat(1.0) / (left * head);
            let reciprocal = -(factor * head).copysign(v[0]);
            v[0] = head.copysign(v[0]);
            for column in tail.chunks_exact_mut(self.rows) {
                reflect_once(v, factor, &mut column[k..]);
            }
            self.reciprocals.push(reciprocal);
            self.factors.push(factor);
        }
        Ok(())
    }

    /// `x <- Qᵀ x`.
    #[inline(always)]
    pub(crate) fn reflect(&self, x: &mut [Lanes]) {
        for (k, &factor) in self.factors.iter().enumerate() {
            reflect_once(&self.column(k)[k..], factor, &mut x[k..]);
        }
    }

    /// `x <- Q x`.
    #[inline(always)]
    pub(crate) fn reflect_back(&self, x: &mut [Lanes]) {
        for (k, &factor) in self.factors.iter().enumerate().rev() {
            reflect_once(&self.column(k)[k..], factor, &mut x[k..]);
        }
    }

    /// `x <- R⁻¹ x`.
    #[inline(always)]
    pub(crate) fn solve(&self, x: &mut [Lanes]) {
        for k in (0..self.columns).rev() {
            let value = x[k] * self.reciprocals[k];
            x[k] = value;
            for (x, r) in x[..k].iter_mut().zip(self.column(k)) {
                lanes_only();
                *x = r.mul_add(-value, *x);
            }
        }
    }

    /// `x <- R⁻ᵀ x`.
    #[inline(always)]
    pub(crate) fn solve_transposed(&self, x: &mut [Lanes]) {
        for k in 0..self.columns {
            let (known, open) = x.split_at_mut(k);
            open[0] = (open[0] - dot(&self.column(k)[..k], known)) * self.reciprocals[k];
        }
    }
}

/// `x <- x - β v vᵀ x`.
#[inline(always)]
fn reflect_once(v: &[Lanes], factor: Lanes, x: &mut [Lanes]) {
    let along = -(dot(v, x) * factor);
    for (x, v) in x.iter_mut().zip(v) {
        lanes_only();
        *x = along.mul_add(*v, *x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another 4 × 3 matrix in each lane.
    fn matrices() -> Reflections {
        let mut matrices = Reflections::default();
        matrices.reset(4, 3);
        for k in 0..3 {
            for (i, x) in matrices.column_mut(k).iter_mut().enumerate() {
                *x = Lanes::from_fn(|lane| (((lane + 2) * (i + 3) * (k + 5)) as f64 * 1.7).sin());
            }
        }
        matrices
    }

    #[test]
    fn factors_make_up_the_matrix() {
        let before = matrices();
        let mut after = before.clone();
        after.eliminate().unwrap();
        for k in 0..3 {
            // Column k is Q times column k of R.
            let mut x = vec![Lanes::ZERO; 4];
            x[..k].copy_from_slice(&after.column(k)[..k]);
            x[k] = Lanes::splat(1.0) / after.reciprocals[k];
            after.reflect_back(&mut x);
            for (found, expected) in x.iter().zip(before.column(k)) {
                for lane in 0..LANES {
                    assert!((found.0[lane] - expected.0[lane]).abs() < 1e-14);
                }
            }
            // And Qᵀ takes it back; R⁻¹ makes a unit vector of it, R⁻ᵀ the same from its row.
            after.reflect(&mut x);
            after.solve(&mut x[..3]);
            let mut row: Vec<Lanes> = (0..3)
                .map(|j| match j {
                    _ if j < k => Lanes::ZERO,
                    _ if j == k => Lanes::splat(1.0) / after.reciprocals[k],
                    _ => after.column(j)[k],
                })
                .collect();
            after.solve_transposed(&mut row);
            for (j, (x, y)) in x.iter().zip(&row).enumerate() {
                let unit = if j == k { 1.0 } else { 0.0 };
                for lane in 0..LANES {
                    assert!((x.0[lane] - unit).abs() < 1e-12);
                    assert!((y.0[lane] - unit).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn names_the_column_that_depends_on_another_and_its_lane() {
        let mut matrices = matrices();
        let first = matrices.column(0).to_vec();
        for (x, first) in matrices.column_mut(1).iter_mut().zip(first) {
            x.0[5] = 2.0 * first.0[5];
        }
        let weak = matrices.eliminate().unwrap_err();
        assert_eq!((weak.lane, weak.column), (5, 1));
        assert!(weak.pivot < 1e-15, "{}", weak.pivot);
    }

    #[test]
    fn what_is_not_finite_has_no_pivot() {
        let mut matrices = matrices();
        matrices.column_mut(2)[1].0[3] = f64::NAN;
        let weak = matrices.eliminate().unwrap_err();
        assert_eq!((weak.lane, weak.column), (3, 2));
        assert!(weak.pivot.is_nan());
    }
}
