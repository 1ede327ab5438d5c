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

use trueaxis_multilateration::Whitened;

use crate::selection::fixed_scan::gram;

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
    /// `Σ`, row after row.
    sigma: Vec<f64>,
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
        };
        bare.extended(base)
    }

    /// That of an eliminated system: `Σ = I`.
    pub(crate) fn arrowhead(parts: Arrowhead) -> Self {
        let width = parts.shared_width;
        let mut sigma = vec![0.0; width * width];
        (0..width).for_each(|k| sigma[k * width + k] = 1.0);
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
            shared_width: width,
            sigma,
        }
    }

    /// Number of observations.
    pub(crate) fn rows(&self) -> usize {
        self.residuals.len()
    }

    /// `yᵀ M y`.
    pub(crate) fn squares(&self) -> f64 {
        self.squares
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
    pub(crate) fn taken_of(&self, x: &[f64]) -> Taken {
        let (own_width, width) = (self.own_width, self.shared_width);
        let mut taken = Taken {
            own: vec![0.0; self.groups * own_width],
            shared: vec![0.0; width],
            through: Vec::new(),
        };
        for (i, &value) in x.iter().enumerate() {
            if value != 0.0 {
                let group = &mut taken.own[self.group_of_row[i] * own_width..][..own_width];
                add(group, self.own_row(i), value);
                add(&mut taken.shared, self.shared_row(i), value);
            }
        }
        let through = (0..width).map(|k| dot(self.sigma_row(k), &taken.shared));
        taken.through = through.collect();
        taken
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
        Self {
            degrees_of_freedom: self.degrees_of_freedom - basis.len() as f64,
            ..self.with(&basis, residuals, squares)
        }
    }

    /// The same with columns whose coefficients have the prior `N(0, I)`, and the logarithm of `|I + Xᵀ M X|`.
    pub(crate) fn beside(&self, columns: &[Vec<f64>]) -> (Self, f64) {
        let gram = gram(self, columns);
        let s: Vec<f64> = columns.iter().map(|c| dot(c, &self.residuals)).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let (mut residuals, mut squares) = (self.residuals.clone(), self.squares);
        let (mut taken, mut ln_price) = (self.taken, 0.0);
        for (value, z, vector) in gram.directions(&s) {
            let part = value / (1.0 + value);
            if part < NOTHING {
                continue;
            }
            taken += part;
            ln_price += value.ln_1p();
            let mut left = vec![0.0; self.rows()];
            for (column, v) in columns.iter().zip(vector) {
                add(&mut left, column, v * (part / value).sqrt());
            }
            self.project(&mut left);
            let along = z * part.sqrt();
            add(&mut residuals, &left, -along);
            squares -= along * along;
            basis.push(left);
        }
        let beside = Self {
            is_soft: true,
            taken,
            ..self.with(&basis, residuals, squares)
        };
        (beside, ln_price)
    }

    /// The same with more columns `T`.
    fn with(&self, basis: &[Vec<f64>], residuals: Vec<f64>, squares: f64) -> Self {
        let (old, width) = (self.shared_width, self.shared_width + basis.len());
        let mut shared = Vec::with_capacity(self.rows() * width);
        for i in 0..self.rows() {
            shared.extend_from_slice(self.shared_row(i));
            shared.extend(basis.iter().map(|unit| unit[i]));
        }
        let mut sigma = vec![0.0; width * width];
        for k in 0..width {
            if k < old {
                sigma[k * width..k * width + old]
                    .copy_from_slice(&self.sigma[k * old..(k + 1) * old]);
            } else {
                sigma[k * width + k] = 1.0;
            }
        }
        Self {
            residuals,
            squares,
            shared,
            shared_width: width,
            sigma,
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

    /// Row of `Σ`.
    pub(crate) fn sigma_row(&self, row: usize) -> &[f64] {
        &self.sigma[row * self.shared_width..(row + 1) * self.shared_width]
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

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `sum += factor · x`.
pub(crate) fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += factor * x;
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
