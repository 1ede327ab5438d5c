//! Gram–Schmidt elimination of eight matrices whose size is known when it is compiled.
//!
//! `A = Q R` with orthogonal columns `q_k` that are not scaled and a unit triangle `R`: without square
//! roots and with one division for each column. Loops are unrolled and numbers stay in registers, so that
//! it takes a fraction of the time of [`crate::reflections`]. Unlike these it loses orthogonality as a
//! column comes near those before it: in the modified form used here, rounding over the part of it that is
//! left (Å. Björck, BIT 7, 1, 1967). Matrices of which little is left are therefore refused long before
//! they are singular; they are for reflections.

use crate::lanes::{Lanes, lanes_only};

/// What must be left of a column after those before it, relative to its length: columns of `Q` are then
/// orthogonal to 1e-13, and a correction, which the next one corrects, is known to ten digits at least.
pub const GRAM_SCHMIDT_TOL: f64 = 1e-3;

/// `A = Q R` of eight matrices with at least as many rows as columns.
#[derive(Debug, Clone, Copy)]
pub struct GramSchmidt<const ROWS: usize, const COLUMNS: usize> {
    columns: [[Lanes; ROWS]; COLUMNS],
    /// `1 / q_k·q_k`.
    reciprocals: [Lanes; COLUMNS],
    /// Column `k` of `R` above its unit diagonal.
    triangle: [[Lanes; COLUMNS]; COLUMNS],
}

impl<const ROWS: usize, const COLUMNS: usize> GramSchmidt<ROWS, COLUMNS> {
    /// Zero matrices.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            columns: [[Lanes::ZERO; ROWS]; COLUMNS],
            reciprocals: [Lanes::ZERO; COLUMNS],
            triangle: [[Lanes::ZERO; COLUMNS]; COLUMNS],
        }
    }

    /// Eliminates matrices, given by columns; false if too little is left of a column of one of them (by
    /// [`GRAM_SCHMIDT_TOL`]) or if it is not finite.
    #[inline(always)]
    pub fn eliminate(&mut self, columns: &[[Lanes; ROWS]; COLUMNS]) -> bool {
        self.columns = *columns;
        let limit = Lanes::splat(GRAM_SCHMIDT_TOL * GRAM_SCHMIDT_TOL);
        let mut least_slack = Lanes::splat(f64::INFINITY);
        for k in 0..COLUMNS {
            let (before, rest) = self.columns.split_at_mut(k);
            let column = &mut rest[0];
            let whole = dot(column, column);
            for (j, q) in before.iter().enumerate() {
                let factor = dot(q, column) * self.reciprocals[j];
                take_off(q, factor, column);
                self.triangle[k][j] = factor;
            }
            let left = dot(column, column);
            let slack = left - limit * whole;
            // A column that is not finite leaves none to the right of it finite: the last slack tells.
            least_slack = Lanes::from_fn(|lane| {
                let (least, slack) = (least_slack.0[lane], slack.0[lane]);
                if least < slack { least } else { slack }
            });
            self.reciprocals[k] = Lanes::splat(1.0) / left;
        }
        let mut determined = true;
        for slack in least_slack.0 {
            determined &= slack > 0.0;
        }
        determined
    }

    /// The upper triangle of `P = 1 - Q (QᵀQ)⁻¹ Qᵀ`, which leaves of a vector what the columns of `A` do
    /// not explain.
    #[inline(always)]
    pub fn fill_projection(&self, projection: &mut [[Lanes; ROWS]; ROWS]) {
        let mut scaled = self.columns;
        for (column, &reciprocal) in scaled.iter_mut().zip(&self.reciprocals) {
            for x in column {
                *x = *x * reciprocal;
            }
        }
        for (i, row) in projection.iter_mut().enumerate() {
            for (j, p) in row.iter_mut().enumerate().skip(i) {
                lanes_only();
                *p = Lanes::splat(if i == j { 1.0 } else { 0.0 });
                for (q, scaled) in self.columns.iter().zip(&scaled) {
                    *p = q[i].mul_add(-scaled[j], *p);
                }
            }
        }
    }

    /// Takes off `x` what the columns of `A` explain of it, writes the factors `t_k` of the `q_k` of
    /// which that is the sum, and returns its square.
    #[inline(always)]
    pub fn explain(&self, x: &mut [Lanes; ROWS], factors: &mut [Lanes; COLUMNS]) -> Lanes {
        let mut squares = Lanes::ZERO;
        for (k, factor) in factors.iter_mut().enumerate() {
            let along = dot(&self.columns[k], x);
            *factor = along * self.reciprocals[k];
            take_off(&self.columns[k], *factor, x);
            squares = along.mul_add(*factor, squares);
        }
        squares
    }

    /// From the factors `t` of the `q_k` to those of the columns of `A`: `R⁻¹ t`.
    #[inline(always)]
    pub fn solve(&self, factors: &mut [Lanes; COLUMNS]) {
        for k in (0..COLUMNS).rev() {
            for j in 0..k {
                factors[j] = self.triangle[k][j].mul_add(-factors[k], factors[j]);
            }
        }
    }
}

impl<const ROWS: usize, const COLUMNS: usize> Default for GramSchmidt<ROWS, COLUMNS> {
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

/// `x <- x - t q`.
#[inline(always)]
fn take_off<const ROWS: usize>(q: &[Lanes; ROWS], factor: Lanes, x: &mut [Lanes; ROWS]) {
    for i in 0..ROWS {
        x[i] = q[i].mul_add(-factor, x[i]);
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
        let mut eliminated = GramSchmidt::new();
        assert!(eliminated.eliminate(&matrix));
        let right: [Lanes; 5] = std::array::from_fn(|i| Lanes::splat((i as f64).cos()));
        let (mut rest, mut x) = (right, [Lanes::ZERO; 3]);
        eliminated.explain(&mut rest, &mut x);
        eliminated.solve(&mut x);
        for i in 0..5 {
            let fitted = matrix[0][i] * x[0] + matrix[1][i] * x[1] + matrix[2][i] * x[2];
            let wrong = right[i] - fitted - rest[i];
            assert!(wrong.0.iter().all(|x| x.abs() < 1e-13), "{wrong:?}");
        }
        for column in &matrix {
            assert!(dot(column, &rest).0.iter().all(|x| x.abs() < 1e-13));
        }
        // The rest is the projection.
        let mut projection = [[Lanes::ZERO; 5]; 5];
        eliminated.fill_projection(&mut projection);
        for i in 0..5 {
            let mut wrong = -rest[i];
            for j in 0..5 {
                wrong += projection[i.min(j)][i.max(j)] * right[j];
            }
            assert!(wrong.0.iter().all(|x| x.abs() < 1e-13), "{wrong:?}");
        }
    }

    #[test]
    fn columns_near_the_limit_are_orthogonal() {
        let mut matrix = matrices();
        let [first, second, third] = &mut matrix;
        for ((a, b), c) in first.iter().zip(second).zip(third) {
            *c = *a - Lanes::splat(3.0) * *b + *c * Lanes::splat(0.03);
        }
        let mut eliminated = GramSchmidt::new();
        assert!(eliminated.eliminate(&matrix));
        let [a, b, c] = &eliminated.columns;
        for (p, q) in [(a, b), (a, c), (b, c)] {
            let lengths = (dot(p, p) * dot(q, q)).sqrt();
            let cosines = dot(p, q) / lengths;
            assert!(cosines.0.iter().all(|x| x.abs() < 1e-13), "{cosines:?}");
        }
    }

    #[test]
    fn a_lane_with_dependent_columns_is_refused() {
        let mut matrix = matrices();
        let [first, second, third] = &mut matrix;
        for ((a, b), c) in first.iter().zip(second).zip(third) {
            c.0[6] = a.0[6] - 3.0 * b.0[6] + 1e-4 * c.0[6];
        }
        assert!(!GramSchmidt::new().eliminate(&matrix));
        let mut matrix = matrices();
        matrix[1][4].0[0] = f64::NAN;
        assert!(!GramSchmidt::new().eliminate(&matrix));
        let mut matrix = matrices();
        for x in &mut matrix[0] {
            x.0[2] = 0.0;
        }
        assert!(!GramSchmidt::new().eliminate(&matrix));
    }
}
