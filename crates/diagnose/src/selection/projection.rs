//! What is left of observations after the base model has absorbed what it can.
//!
//! `M = I - O Oᵀ [same group] - T Σ Tᵀ`; the parts of an arrowhead system, or, without groups, the
//! orthonormal columns `T` of a small dense one (`Σ = I`).
//!
//! Columns with a prior `N(0, I)` of their coefficients ([`Projection::beside`]) join the covariance,
//! `V = I + X Xᵀ`. All that is asked of `M` then is asked of
//!
//! ```text
//! R = V⁻¹ - V⁻¹A (AᵀV⁻¹A)⁻¹ AᵀV⁻¹ = M - M X (I + Xᵀ M X)⁻¹ Xᵀ M
//! ```
//!
//! (A: the base model), which has the same form with more columns `T`, but is no projection any more.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use trueaxis_leastsquares::{dot, in_widest_registers};
use trueaxis_multilateration::Whitened;

use crate::selection::Gram;
use crate::selection::fixed_scan::gram_matrix_of;

/// Whitened residuals and the projection that made them.
#[derive(Debug, Clone)]
pub(crate) struct Projection {
    /// `e = M y`.
    pub(crate) residuals: Vec<f64>,
    /// `yᵀ M y`.
    squares: f64,
    /// Observations less parameters of the base model.
    pub(crate) degrees_of_freedom: f64,
    /// Columns with a prior as far as the data take them, `Σ x/(1 + x)`.
    pub(crate) taken: f64,
    /// Whether columns with a prior are in it, so that `M² ≠ M`.
    is_soft: bool,
    group_of_row: Vec<usize>,
    groups: usize,
    /// `O`, row after row.
    own: Vec<f64>,
    own_width: usize,
    /// `T`, row after row.
    shared: Vec<f64>,
    shared_width: usize,
    /// `Σ` of the first columns of `T`, row after row; of the others it is the identity.
    sigma: Vec<f64>,
    sigma_width: usize,
}

/// The parts of a projection whose shared columns are orthonormal, and orthogonal to those of all groups.
pub(crate) struct Arrowhead {
    /// `e = M y`.
    pub(crate) residuals: Vec<f64>,
    /// Trace of `M`.
    pub(crate) degrees_of_freedom: f64,
    pub(crate) group_of_row: Vec<usize>,
    pub(crate) groups: usize,
    /// `O`, row after row.
    pub(crate) own: Vec<f64>,
    pub(crate) own_width: usize,
    /// `T`, row after row.
    pub(crate) shared: Vec<f64>,
    pub(crate) shared_width: usize,
}

/// What must be left of a column, relative to its length, for it to count as something new.
const NEW_TOL: f64 = 1e-6;

/// Columns that are taken of together: rows of `O` and `T` are read once for all of them.
const TOGETHER: usize = 8;

/// A direction that the data know so much less than its prior does is left out of the covariance.
const NOTHING: f64 = 0.02;

impl Projection {
    /// That of an adjusted network.
    pub(crate) fn of_network(whitened: &Whitened) -> Self {
        Self {
            residuals: whitened.residuals.clone(),
            squares: dot(&whitened.residuals, &whitened.residuals),
            is_soft: false,
            taken: 0.0,
            degrees_of_freedom: whitened.degrees_of_freedom as f64,
            group_of_row: whitened.group_of_row.clone(),
            groups: whitened.groups,
            own: whitened.own.clone(),
            own_width: whitened.own_width,
            shared: whitened.shared.clone(),
            shared_width: whitened.shared_width,
            sigma: whitened.reduced_inverse.clone(),
            sigma_width: whitened.shared_width,
        }
    }

    /// That of whitened observations `y` and the columns of a base model.
    pub(crate) fn dense(observations: Vec<f64>, base: &[Vec<f64>]) -> Self {
        let rows = observations.len();
        let bare = Self {
            degrees_of_freedom: rows as f64,
            squares: dot(&observations, &observations),
            is_soft: false,
            taken: 0.0,
            residuals: observations,
            group_of_row: vec![0; rows],
            groups: 1,
            own: Vec::new(),
            own_width: 0,
            shared: Vec::new(),
            shared_width: 0,
            sigma: Vec::new(),
            sigma_width: 0,
        };
        bare.extended(base)
    }

    /// That of an eliminated system: `Σ = I`.
    pub(crate) fn arrowhead(parts: Arrowhead) -> Self {
        Self {
            squares: dot(&parts.residuals, &parts.residuals),
            is_soft: false,
            taken: 0.0,
            residuals: parts.residuals,
            degrees_of_freedom: parts.degrees_of_freedom,
            group_of_row: parts.group_of_row,
            groups: parts.groups,
            own: parts.own,
            own_width: parts.own_width,
            shared: parts.shared,
            shared_width: parts.shared_width,
            sigma: Vec::new(),
            sigma_width: 0,
        }
    }

    /// The same of other whitened residuals.
    pub(crate) fn with_residuals(&self, y: &[f64]) -> Self {
        let mut residuals = y.to_vec();
        self.project(&mut residuals);
        Self {
            squares: dot(y, &residuals),
            residuals,
            ..self.clone()
        }
    }

    /// Number of observations.
    pub(crate) fn rows(&self) -> usize {
        self.residuals.len()
    }

    /// `yᵀ M y`.
    pub(crate) fn squares(&self) -> f64 {
        self.squares.max(0.0)
    }

    /// `x <- M x`.
    pub(crate) fn project(&self, x: &mut [f64]) {
        let taken = self.taken_of(x);
        for (i, value) in x.iter_mut().enumerate() {
            let group = &taken.own[self.group_of_row[i] * self.own_width..][..self.own_width];
            *value -= dot(self.own_row(i), group) + dot(self.shared_row(i), &taken.through);
        }
    }

    /// What the base model takes of a whitened column.
    fn taken_of(&self, x: &[f64]) -> Taken {
        let mut taken = self.nothing_taken();
        self.add_taken(&mut [(x, &mut taken)]);
        taken
    }

    /// What the base model takes of each of some whitened columns.
    pub(crate) fn taken_of_all<'c>(
        &self,
        columns: impl IntoIterator<Item = &'c Vec<f64>>,
    ) -> Vec<Taken> {
        let columns: Vec<&[f64]> = columns.into_iter().map(Vec::as_slice).collect();
        let mut all: Vec<Taken> = columns.iter().map(|_| self.nothing_taken()).collect();
        let mut pairs: Vec<(&[f64], &mut Taken)> = columns.into_iter().zip(&mut all).collect();
        pairs
            .chunks_mut(TOGETHER)
            .for_each(|some| self.add_taken(some));
        all
    }

    fn nothing_taken(&self) -> Taken {
        Taken {
            own: vec![0.0; self.groups * self.own_width],
            shared: vec![0.0; self.shared_width],
            through: Vec::new(),
        }
    }

    /// Takes of some columns, row after row of `O` and `T`.
    fn add_taken(&self, columns: &mut [(&[f64], &mut Taken)]) {
        in_widest_registers(
            #[inline(always)]
            || {
                for i in 0..self.rows() {
                    for (x, taken) in &mut *columns {
                        if x[i] != 0.0 {
                            let first = self.group_of_row[i] * self.own_width;
                            let group = &mut taken.own[first..][..self.own_width];
                            add(group, self.own_row(i), x[i]);
                            add(&mut taken.shared, self.shared_row(i), x[i]);
                        }
                    }
                }
            },
        );
        for (_, taken) in columns {
            let (dense, rest) = taken.shared.split_at(self.sigma_width);
            let through = (0..self.sigma_width).map(|k| dot(self.sigma_row(k), dense));
            taken.through = through.chain(rest.iter().copied()).collect();
        }
    }

    /// The projection after columns have joined the base model.
    pub(crate) fn extended(&self, columns: &[Vec<f64>]) -> Self {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let (mut residuals, mut squares) = (self.residuals.clone(), self.squares);
        for column in columns {
            let length = dot(column, column).sqrt();
            let mut left = column.clone();
            // Twice, so that rounding does not stay.
            for _ in 0..if self.is_soft { 1 } else { 2 } {
                let before = left.clone();
                self.project(&mut left);
                for unit in &basis {
                    add(&mut left, unit, -dot(unit, &before));
                }
            }
            // Of a projection the same, with less rounding.
            let square = dot(if self.is_soft { column } else { &left }, &left);
            let norm = square.max(0.0).sqrt();
            if norm > NEW_TOL * length {
                left.iter_mut().for_each(|x| *x /= norm);
                let along = match self.is_soft {
                    true => dot(column, &residuals) / norm,
                    false => dot(&left, &residuals),
                };
                add(&mut residuals, &left, -along);
                squares -= along * along;
                basis.push(left);
            }
        }
        let more = basis.len();
        let by_rows = (0..self.rows()).flat_map(|i| basis.iter().map(move |unit| unit[i]));
        let by_rows: Vec<f64> = by_rows.collect();
        Self {
            degrees_of_freedom: self.degrees_of_freedom - more as f64,
            ..self.with(&by_rows, more, residuals, squares)
        }
    }

    /// The same with columns whose coefficients have the prior `N(0, I)`, and the logarithm of `|I + Xᵀ M X|`.
    pub(crate) fn beside(&self, columns: &[Vec<f64>]) -> (Self, f64) {
        let taken_of = self.taken_of_all(columns);
        let before: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let gram = Gram::new(&gram_matrix_of(columns, &taken_of), &before);
        let s: Vec<f64> = columns.iter().map(|c| dot(c, &self.residuals)).collect();
        // Scaled eigenvectors, an element for each direction that is kept; row after row of X.
        let kept = || {
            let all = gram.directions(&s);
            let parts = all.map(|(value, z, vector)| (value, value / (1.0 + value), z, vector));
            parts.filter(|(_, part, _, _)| *part >= NOTHING)
        };
        let width = kept().count();
        let mut scaled = vec![0.0; columns.len() * width];
        let (mut taken, mut ln_price) = (self.taken, 0.0);
        let (mut residuals, mut squares) = (self.residuals.clone(), self.squares);
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
        let basis = self.projected(columns, &taken_of, &scaled, width);
        for (residual, row) in residuals.iter_mut().zip(basis.chunks_exact(width.max(1))) {
            *residual -= dot(row, &along);
        }
        let beside = Self {
            is_soft: true,
            taken,
            ..self.with(&basis, width, residuals, squares)
        };
        (beside, ln_price)
    }

    /// `M X V`, row after row, of columns `X`, what is taken of them, and `V` (`width` columns), row after row.
    fn projected(
        &self,
        columns: &[Vec<f64>],
        taken_of: &[Taken],
        v: &[f64],
        width: usize,
    ) -> Vec<f64> {
        let (rows, count) = (self.rows(), columns.len());
        let mut basis = vec![0.0; rows * width];
        let times_v = |rows: usize, of_column: &dyn Fn(usize, usize) -> f64| {
            let mut product = vec![0.0; rows * width];
            let factor = Mat::from_fn(rows, count, of_column);
            add_product(&mut product, factor.as_ref(), v, 1.0);
            product
        };
        let own = times_v(self.groups * self.own_width, &|r, k| taken_of[k].own[r]);
        let through = times_v(self.shared_width, &|r, k| taken_of[k].through[r]);
        let shared = MatRef::from_row_major_slice(&self.shared, rows, self.shared_width);
        add_product(&mut basis, shared, &through, -1.0);
        // The columns with anything in a row: those of one course of a disturbance. Rows of one course follow each other.
        let concerned = |i: usize| {
            let is_there = |column: &Vec<f64>| column[i] != 0.0;
            let first = columns.iter().position(is_there).unwrap_or(0);
            (
                first,
                columns.iter().rposition(is_there).map_or(first, |k| k + 1),
            )
        };
        let concerned: Vec<(usize, usize)> = (0..rows).map(concerned).collect();
        let mut start = 0;
        for alike in concerned.chunk_by(|a, b| a == b) {
            let (first, end) = alike[0];
            let own = Mat::from_fn(alike.len(), end - first, |i, k| {
                columns[first + k][start + i]
            });
            let of_these = &mut basis[start * width..(start + alike.len()) * width];
            add_product(of_these, own.as_ref(), &v[first * width..end * width], 1.0);
            start += alike.len();
        }
        in_widest_registers(
            #[inline(always)]
            || {
                for (i, row) in basis.chunks_exact_mut(width.max(1)).enumerate() {
                    let group = &own[self.group_of_row[i] * self.own_width * width..];
                    for (part, o) in group.chunks_exact(width).zip(self.own_row(i)) {
                        add(row, part, -o);
                    }
                }
            },
        );
        basis
    }

    /// The same with so many more columns `T`, row after row.
    fn with(&self, basis: &[f64], more: usize, residuals: Vec<f64>, squares: f64) -> Self {
        let width = self.shared_width + more;
        let mut shared = Vec::with_capacity(self.rows() * width);
        for i in 0..self.rows() {
            shared.extend_from_slice(self.shared_row(i));
            shared.extend_from_slice(&basis[i * more..(i + 1) * more]);
        }
        Self {
            residuals,
            squares,
            shared,
            shared_width: width,
            sigma: self.sigma.clone(),
            sigma_width: self.sigma_width,
            is_soft: self.is_soft,
            taken: self.taken,
            degrees_of_freedom: self.degrees_of_freedom,
            group_of_row: self.group_of_row.clone(),
            groups: self.groups,
            own: self.own.clone(),
            own_width: self.own_width,
        }
    }

    pub(crate) fn groups(&self) -> usize {
        self.groups
    }

    pub(crate) fn group_of_row(&self, row: usize) -> usize {
        self.group_of_row[row]
    }

    /// Row of `O`.
    pub(crate) fn own_row(&self, row: usize) -> &[f64] {
        &self.own[row * self.own_width..(row + 1) * self.own_width]
    }

    /// Row of `T`.
    pub(crate) fn shared_row(&self, row: usize) -> &[f64] {
        &self.shared[row * self.shared_width..(row + 1) * self.shared_width]
    }

    /// Row of `Σ` up to where it is the identity, of the first columns of `T`.
    pub(crate) fn sigma_row(&self, row: usize) -> &[f64] {
        &self.sigma[row * self.sigma_width..(row + 1) * self.sigma_width]
    }

    /// Number of columns of `T` from which on `Σ` is the identity.
    pub(crate) fn sigma_width(&self) -> usize {
        self.sigma_width
    }

    /// Columns of `O` and `T`.
    pub(crate) fn widths(&self) -> (usize, usize) {
        (self.own_width, self.shared_width)
    }
}

/// `Oᵀx` of each group, `Tᵀx` and `Σ Tᵀx`.
pub(crate) struct Taken {
    own: Vec<f64>,
    shared: Vec<f64>,
    through: Vec<f64>,
}

impl Taken {
    /// `xᵀ (I - M) y`.
    pub(crate) fn product(&self, other: &Self) -> f64 {
        dot(&self.own, &other.own) + dot(&self.shared, &other.through)
    }
}

/// `sum += factor · x`.
#[inline(always)]
pub(crate) fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += factor * x;
    }
}

/// `sum += factor · A B`; `sum` and `B` row after row.
fn add_product(sum: &mut [f64], a: MatRef<'_, f64>, b: &[f64], factor: f64) {
    let (rows, inner) = (a.nrows(), a.ncols());
    if rows * inner * sum.len() > 0 {
        let width = sum.len() / rows;
        let sum = MatMut::from_row_major_slice_mut(sum, rows, width);
        let b = MatRef::from_row_major_slice(b, inner, width);
        matmul(sum, Accum::Add, a, b, factor, Par::Seq);
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

    /// Columns with a prior, then free ones: the same as by dense matrices, to the part that is left out of weak
    /// directions; here all are strong.
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
