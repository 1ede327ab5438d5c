//! Orthogonal elimination of eight matrices whose size is known when it is compiled.
//!
//! The same as [`crate::reflections`] for the sizes that matter most: loops are unrolled and numbers
//! stay in registers, which takes a third of the time for 4 × 3.

use crate::lanes::Lanes;
use crate::reflections::BLOCK_RANK_TOL;

/// `A = Q [R; 0]` of eight matrices with more rows than columns, `Q` as its reflections
/// `1 - β_k v_k v_kᵀ`.
#[derive(Debug, Clone, Copy)]
pub struct SmallReflections<const ROWS: usize, const COLUMNS: usize> {
    /// The columns of `R`; below the diagonal of no meaning.
    triangle: [[Lanes; ROWS]; COLUMNS],
    /// `v_k`, with zeros before place `k`.
    vectors: [[Lanes; ROWS]; COLUMNS],
    /// `β_k`.
    factors: [Lanes; COLUMNS],
    /// Reciprocals of the diagonal of `R`.
    reciprocals: [Lanes; COLUMNS],
}

impl<const ROWS: usize, const COLUMNS: usize> SmallReflections<ROWS, COLUMNS> {
    /// Zero matrices.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            triangle: [[Lanes::ZERO; ROWS]; COLUMNS],
            vectors: [[Lanes::ZERO; ROWS]; COLUMNS],
            factors: [Lanes::ZERO; COLUMNS],
            reciprocals: [Lanes::ZERO; COLUMNS],
        }
    }

    /// Eliminates matrices, given by columns; false if a column of one of them hangs on those before
    /// it (by the limit of [`BLOCK_RANK_TOL`]) or is not finite.
    #[inline(always)]
    pub fn eliminate(&mut self, columns: &[[Lanes; ROWS]; COLUMNS]) -> bool {
        self.triangle = *columns;
        let limit = Lanes::splat(BLOCK_RANK_TOL * BLOCK_RANK_TOL);
        let mut least_slack = Lanes::splat(f64::INFINITY);
        for k in 0..COLUMNS {
            let mut above = Lanes::ZERO;
            for i in 0..k {
                above = self.triangle[k][i].mul_add(self.triangle[k][i], above);
            }
            let mut v = self.triangle[k];
            for x in &mut v[..k] {
                *x = Lanes::ZERO;
            }
            let squares = dot(&v, &v);
            let slack = squares - limit * (squares + above);
            // A column that is not finite leaves none to the right of it finite: the last slack tells.
            least_slack = Lanes::from_fn(|lane| {
                let (least, slack) = (least_slack.0[lane], slack.0[lane]);
                if least < slack { least } else { slack }
            });
            // v = x + sign(x0) |x| e0, so that v·v / 2 = |x| (|x| + |x0|) = |x| |v0|.
            let left = squares.sqrt();
            let head = left + v[k].abs();
            let factor = Lanes::splat(1.0) / (left * head);
            self.factors[k] = factor;
            self.reciprocals[k] = -(factor * head).copysign(v[k]);
            v[k] = head.copysign(v[k]);
            self.vectors[k] = v;
            for j in k + 1..COLUMNS {
                reflect_once(&v, factor, &mut self.triangle[j]);
            }
        }
        let mut determined = true;
        for slack in least_slack.0 {
            determined &= slack > 0.0;
        }
        determined
    }

    /// `x <- Qᵀ x`.
    #[inline(always)]
    pub fn reflect(&self, x: &mut [Lanes; ROWS]) {
        for k in 0..COLUMNS {
            reflect_once(&self.vectors[k], self.factors[k], x);
        }
    }

    /// Column `k` of `Q`.
    #[inline(always)]
    pub fn column(&self, k: usize) -> [Lanes; ROWS] {
        let mut x = [Lanes::ZERO; ROWS];
        x[k] = Lanes::splat(1.0);
        for k in (0..COLUMNS).rev() {
            reflect_once(&self.vectors[k], self.factors[k], &mut x);
        }
        x
    }

    /// `R⁻¹ y` of the first places of `y`.
    #[inline(always)]
    pub fn solve(&self, y: &[Lanes; ROWS]) -> [Lanes; COLUMNS] {
        let mut x = [Lanes::ZERO; COLUMNS];
        x.copy_from_slice(&y[..COLUMNS]);
        for k in (0..COLUMNS).rev() {
            x[k] = x[k] * self.reciprocals[k];
            for i in 0..k {
                x[i] = self.triangle[k][i].mul_add(-x[k], x[i]);
            }
        }
        x
    }
}

impl<const ROWS: usize, const COLUMNS: usize> Default for SmallReflections<ROWS, COLUMNS> {
    fn default() -> Self {
        Self::new()
    }
}

#[inline(always)]
fn dot<const ROWS: usize>(a: &[Lanes; ROWS], b: &[Lanes; ROWS]) -> Lanes {
    let mut sum = a[0] * b[0];
    for i in 1..ROWS {
        sum = a[i].mul_add(b[i], sum);
    }
    sum
}

/// `x <- x - β v vᵀ x`.
#[inline(always)]
fn reflect_once<const ROWS: usize>(v: &[Lanes; ROWS], factor: Lanes, x: &mut [Lanes; ROWS]) {
    let along = -(dot(v, x) * factor);
    for i in 0..ROWS {
        x[i] = along.mul_add(v[i], x[i]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another 5 × 3 matrix in each lane, by columns.
    fn matrices() -> [[Lanes; 5]; 3] {
        std::array::from_fn(|k| {
            std::array::from_fn(|i| {
                Lanes::from_fn(|lane| (((lane + 2) * (i + 3) * (k + 5)) as f64 * 1.7).sin())
            })
        })
    }

    #[test]
    fn solves_in_the_sense_of_least_squares() {
        let matrix = matrices();
        let mut eliminated = SmallReflections::new();
        assert!(eliminated.eliminate(&matrix));
        let right: [Lanes; 5] = std::array::from_fn(|i| Lanes::splat((i as f64).cos()));
        let mut y = right;
        eliminated.reflect(&mut y);
        let x = eliminated.solve(&y);
        let rest: [Lanes; 5] = std::array::from_fn(|i| {
            let fitted = matrix[0][i] * x[0] + matrix[1][i] * x[1] + matrix[2][i] * x[2];
            right[i] - fitted
        });
        // The rest is orthogonal to all columns, and what the columns of Q beyond them make of it.
        for column in &matrix {
            assert!(dot(column, &rest).0.iter().all(|x| x.abs() < 1e-13));
        }
        for (k, y) in y.iter().enumerate().skip(3) {
            let along = dot(&eliminated.column(k), &rest) - *y;
            assert!(along.0.iter().all(|x| x.abs() < 1e-13), "{along:?}");
        }
    }

    #[test]
    fn a_lane_with_dependent_columns_is_refused() {
        let mut matrix = matrices();
        let [first, second, third] = &mut matrix;
        for ((a, b), c) in first.iter().zip(second).zip(third) {
            c.0[6] = a.0[6] - 3.0 * b.0[6];
        }
        assert!(!SmallReflections::new().eliminate(&matrix));
        let mut matrix = matrices();
        matrix[1][4].0[0] = f64::NAN;
        assert!(!SmallReflections::new().eliminate(&matrix));
        let mut matrix = matrices();
        for x in &mut matrix[0] {
            x.0[2] = 0.0;
        }
        assert!(!SmallReflections::new().eliminate(&matrix));
    }
}
