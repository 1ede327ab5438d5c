//! Columns with a prior `N(0, I)` of their coefficients join the covariance, `V = I + X Xᵀ`. `M` is then replaced by
//!
//! ```text
//! R = V⁻¹ - V⁻¹A (AᵀV⁻¹A)⁻¹ AᵀV⁻¹ = M - M X (I + Xᵀ M X)⁻¹ Xᵀ M
//! ```
//!
//! (A: the base model), which has the same form with more columns `T`, but is not a projection.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};
use rayon::prelude::*;
use trueaxis_leastsquares::{dot, in_widest_registers};

use crate::gram_matrix::gram_matrix_of;
use crate::projection::{Taken, add};
use crate::{Gram, Projection};

/// Combinations that the data determine less than this share, against their prior, are left out of the covariance.
const NOTHING: f64 = 0.02;

/// Rows that one thread takes at a time.
const ROWS_TOGETHER: usize = 512;

impl Projection {
    /// The projection with columns whose coefficients have the prior `N(0, I)`, and the logarithm of `|I + Xᵀ M X|`.
    pub fn beside(&self, columns: &[Vec<f64>]) -> (Self, f64) {
        let taken_of = self.taken_of_all(columns.iter().map(Vec::as_slice));
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let gram = Gram::new(&gram_matrix_of(columns, (&taken_of, 0)), &before);
        let s = self.along(columns);
        // The combinations that are kept; `scaled` are their scaled eigenvectors, row after row of X.
        let kept = || {
            let all = gram.combinations(&s);
            let parts = all.map(|(value, z, vector)| (value, value / (1.0 + value), z, vector));
            parts.filter(|(_, part, _, _)| *part >= NOTHING)
        };
        let width = kept().count();
        let mut scaled = vec![0.0; columns.len() * width];
        let (mut taken, mut ln_price, mut squares) = (self.taken, 0.0, self.squares);
        let mut along = Vec::with_capacity(width);
        for (m, (value, part, z, vector)) in kept().enumerate() {
            taken += part;
            ln_price += value.ln_1p();
            for (k, v) in vector.iter().enumerate() {
                scaled[k * width + m] = v * (part / value).sqrt();
            }
            along.push(z * part.sqrt());
            squares -= z * z * part;
        }
        let beside = self.joined(columns, &taken_of, &scaled, &along);
        let beside = Self {
            is_soft: true,
            taken,
            squares,
            ..beside
        };
        (beside, ln_price)
    }

    /// The same with `M X V` as further columns `T`, given the columns `X`, what is taken of them, and `V`, row after
    /// row; the residuals lose `along` times these columns.
    fn joined(&self, columns: &[Vec<f64>], taken_of: &Taken, v: &[f64], along: &[f64]) -> Self {
        let width = along.len();
        if width == 0 {
            return self.clone();
        }
        // Matrices are stored row after row, so each is its own transpose here.
        let times_v = |rows: usize, of_column: &dyn Fn(usize, usize) -> f64| {
            let mut product = vec![0.0; rows * width];
            let factor = DMatrix::from_fn(columns.len(), rows, of_column);
            add_product(&mut product, factor.as_view(), v, 1.0);
            product
        };
        let own = times_v(self.groups * self.own_width, &|k, r| taken_of.own(k)[r]);
        let through = times_v(self.shared_width, &|k, r| taken_of.through(k)[r]);
        let basis = |rows: Range<usize>| {
            let mut basis = self.projected(columns, rows.clone(), v, &through);
            in_widest_registers(
                #[inline(always)]
                || {
                    for (i, row) in rows.clone().zip(basis.chunks_exact_mut(width)) {
                        let group = &own[self.group_of_row[i] * self.own_width * width..];
                        for (part, o) in group.chunks_exact(width).zip(self.own_row(i)) {
                            add(row, part, -o);
                        }
                    }
                },
            );
            basis
        };
        let shared_width = self.shared_width + width;
        let mut shared = vec![0.0; self.rows() * shared_width];
        let mut residuals = self.residuals.clone();
        let parts = shared.par_chunks_mut(ROWS_TOGETHER * shared_width);
        let parts = parts.zip(residuals.par_chunks_mut(ROWS_TOGETHER));
        parts.enumerate().for_each(|(part, (shared, residuals))| {
            let first = part * ROWS_TOGETHER;
            let basis = basis(first..first + residuals.len());
            let of_rows = shared.chunks_exact_mut(shared_width).zip(residuals);
            for (i, (row, residual)) in of_rows.enumerate() {
                let new = &basis[i * width..(i + 1) * width];
                row[..self.shared_width].copy_from_slice(self.shared_row(first + i));
                row[self.shared_width..].copy_from_slice(new);
                *residual -= dot(new, along);
            }
        });
        Self {
            shared: Arc::new(shared),
            shared_width,
            residuals,
            ..self.clone()
        }
    }

    /// `(X - T Σ TᵀX) V` of some rows, row after row; `through` is `Σ TᵀX V`.
    fn projected(
        &self,
        columns: &[Vec<f64>],
        rows: Range<usize>,
        v: &[f64],
        through: &[f64],
    ) -> Vec<f64> {
        let width = v.len() / columns.len();
        let mut basis = vec![0.0; rows.len() * width];
        let shared = &self.shared[rows.start * self.shared_width..rows.end * self.shared_width];
        let shared = DMatrixView::from_slice(shared, self.shared_width, rows.len());
        add_product(&mut basis, shared, through, -1.0);
        // The columns that are not zero in a row: those of one course of a disturbance. Courses have adjacent rows.
        let concerned = |i: usize| {
            let is_there = |column: &Vec<f64>| column[i] != 0.0;
            let first = columns.iter().position(is_there).unwrap_or(0);
            (
                first,
                columns.iter().rposition(is_there).map_or(first, |k| k + 1),
            )
        };
        let concerned: Vec<(usize, usize)> = rows.clone().map(concerned).collect();
        let mut start = 0;
        for alike in concerned.chunk_by(|a, b| a == b) {
            let (first, end) = alike[0];
            let own = DMatrix::from_fn(end - first, alike.len(), |k, i| {
                columns[first + k][rows.start + start + i]
            });
            let of_these = &mut basis[start * width..(start + alike.len()) * width];
            add_product(of_these, own.as_view(), &v[first * width..end * width], 1.0);
            start += alike.len();
        }
        basis
    }
}

/// `sum += factor · A B`; `sum` and `B` row after row, `A` transposed.
fn add_product(sum: &mut [f64], a: DMatrixView<'_, f64>, b: &[f64], factor: f64) {
    let (inner, rows) = a.shape();
    if rows * inner * sum.len() > 0 {
        let width = sum.len() / rows;
        let b = DMatrixView::from_slice(b, width, inner);
        DMatrixViewMut::from_slice(sum, width, rows).gemm(factor, &b, &a, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// `R = V⁻¹ - V⁻¹A (AᵀV⁻¹A)⁻¹ AᵀV⁻¹`, `V = I + X Xᵀ`, from dense matrices.
    fn dense(a: &DMatrix<f64>, x: &DMatrix<f64>) -> DMatrix<f64> {
        let n = a.nrows();
        let v = (DMatrix::identity(n, n) + x * x.transpose()).try_inverse();
        let v = v.expect("positive definite");
        let normal = (a.transpose() * &v * a).try_inverse().expect("full rank");
        &v - &v * a * normal * a.transpose() * &v
    }

    /// Columns with a prior, then free ones: the same as by dense matrices, except for weak combinations, which are
    /// left out; here all are strong.
    #[test]
    fn columns_with_a_prior_are_in_the_covariance() {
        let mut generator = ChaCha8Rng::seed_from_u64(1);
        let mut draw = |rows: usize, columns: usize, size: f64| {
            DMatrix::from_fn(rows, columns, |_, _| {
                let drawn: f64 = StandardNormal.sample(&mut generator);
                size * drawn
            })
        };
        let (base, smooth, free) = (draw(30, 4, 1.0), draw(30, 5, 2.0), draw(30, 2, 1.0));
        let y = draw(30, 1, 1.0);
        let columns = |m: &DMatrix<f64>| -> Vec<Vec<f64>> {
            m.column_iter()
                .map(|c| c.iter().copied().collect())
                .collect()
        };
        let plain = Projection::dense(columns(&y)[0].clone(), &columns(&base));
        let (beside, ln_price) = plain.beside(&columns(&smooth));
        let extended = beside.extended(&columns(&free));
        let all = DMatrix::from_fn(30, 6, |i, k| {
            if k < 4 {
                base[(i, k)]
            } else {
                free[(i, k - 4)]
            }
        });
        for (projection, a) in [(&beside, &base), (&extended, &all)] {
            let r = dense(a, &smooth);
            let expected: DVector<f64> = (&r * &y).column(0).into_owned();
            let squares = y.column(0).dot(&expected);
            assert!((projection.squares() - squares).abs() < 1e-9 * squares);
            let found = DVector::from_column_slice(&projection.residuals);
            assert!((found - expected).norm() < 1e-9);
            let mut x = columns(&y)[0].clone();
            projection.project(&mut x);
            assert!((dot(&x, &columns(&y)[0]) - squares).abs() < 1e-9 * squares);
        }
        let r = dense(&base, &DMatrix::zeros(30, 1));
        let gram = DMatrix::identity(5, 5) + smooth.transpose() * r * &smooth;
        assert!((ln_price - gram.determinant().ln()).abs() < 1e-9);
    }
}
