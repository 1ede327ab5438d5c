//! One block's whitened rows and their elimination by Householder reflections.

use crate::Error;

/// The rows `[A | B | r]` of one block: columns of the block's own unknowns, of the shared ones,
/// and the residual (observed minus computed), all whitened to unit standard deviation.
///
/// Columns are contiguous. New rows are zero.
#[derive(Debug, Clone, Default)]
pub struct BlockRows {
    rows: usize,
    block: usize,
    shared: usize,
    data: Vec<f64>,
}

/// What is left of a column after the columns before it, relative to its length, below which an
/// unknown counts as free: its uncertainty would be a million times that of a direct reading.
const BLOCK_RANK_TOL: f64 = 1e-6;

impl BlockRows {
    /// Zero rows for `block` own and `shared` shared unknowns.
    pub fn new(rows: usize, block: usize, shared: usize) -> Self {
        let mut new = Self::default();
        new.reset(rows, block, shared);
        new
    }

    /// Makes these zero rows of another shape; keeps the memory.
    pub fn reset(&mut self, rows: usize, block: usize, shared: usize) {
        (self.rows, self.block, self.shared) = (rows, block, shared);
        self.data.clear();
        self.data.resize(rows * (block + shared + 1), 0.0);
    }

    /// Column of the block's own unknown `k`: derivative of the observations.
    pub fn block_mut(&mut self, k: usize) -> &mut [f64] {
        self.column_mut(k)
    }

    /// Column of the shared unknown `k`.
    pub fn shared_mut(&mut self, k: usize) -> &mut [f64] {
        self.column_mut(self.block + k)
    }

    /// The residuals, observed minus computed.
    pub fn residual_mut(&mut self) -> &mut [f64] {
        self.column_mut(self.block + self.shared)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    pub(crate) fn block_unknowns(&self) -> usize {
        self.block
    }

    pub(crate) fn column(&self, k: usize) -> &[f64] {
        &self.data[k * self.rows..(k + 1) * self.rows]
    }

    fn column_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.data[k * self.rows..(k + 1) * self.rows]
    }

    /// Reflects the block's columns to upper triangular form.
    ///
    /// Afterwards the first `block` rows hold `[R | C | c]` with `R x + C s = c`; the rows below
    /// are free of the block's unknowns.
    pub(crate) fn triangularise(&mut self, number: usize) -> Result<(), Error> {
        let (rows, unknowns) = (self.rows, self.block);
        if rows < unknowns {
            return Err(Error::TooFewRows {
                block: number,
                rows,
                unknowns,
            });
        }
        if !self.data.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite {
                what: "a whitened row",
            });
        }
        for k in 0..unknowns {
            let (head, tail) = self.data.split_at_mut((k + 1) * rows);
            let column = &mut head[k * rows..];
            // Reflections keep lengths, so the whole column still has its original length.
            let length = norm(column);
            let pivot_down = &mut column[k..];
            let left = norm(pivot_down);
            if left <= BLOCK_RANK_TOL * length {
                let pivot = if length > 0.0 { left / length } else { 0.0 };
                let limit = BLOCK_RANK_TOL;
                return Err(Error::BlockRank {
                    block: number,
                    unknown: k,
                    pivot,
                    limit,
                });
            }
            // v = x + sign(x0) |x| e0, scaled so that v·v = 2 |x| (|x| + |x0|).
            let alpha = if pivot_down[0] > 0.0 { -left } else { left };
            pivot_down[0] -= alpha;
            let half_vv = left * pivot_down[0].abs();
            for column in tail.chunks_exact_mut(rows) {
                let target = &mut column[k..];
                let factor = dot(pivot_down, target) / half_vv;
                for (t, v) in target.iter_mut().zip(pivot_down.iter()) {
                    *t -= factor * v;
                }
            }
            pivot_down[0] = alpha;
            pivot_down[1..].fill(0.0);
        }
        Ok(())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_unknown_that_depends_on_another() {
        let mut rows = BlockRows::new(3, 2, 0);
        rows.block_mut(0).copy_from_slice(&[1.0, 2.0, 3.0]);
        rows.block_mut(1).copy_from_slice(&[2.0, 4.0, 6.0]);
        let error = rows.triangularise(7).unwrap_err();
        assert!(
            matches!(
                error,
                Error::BlockRank {
                    block: 7,
                    unknown: 1,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn keeps_the_normal_equations() {
        let (a, b) = ([3.0, 1.0, -2.0, 0.5], [1.0, -1.0, 4.0, 2.0]);
        let mut rows = BlockRows::new(4, 1, 1);
        rows.block_mut(0).copy_from_slice(&a);
        rows.shared_mut(0).copy_from_slice(&b);
        rows.triangularise(0).unwrap();
        let (ra, rb) = (rows.column(0), rows.column(1));
        assert!((dot(ra, ra) - dot(&a, &a)).abs() < 1e-13);
        assert!((dot(ra, rb) - dot(&a, &b)).abs() < 1e-13);
        assert!((dot(rb, rb) - dot(&b, &b)).abs() < 1e-13);
        assert!(ra[1..].iter().all(|x| x.abs() < f64::MIN_POSITIVE));
    }
}
