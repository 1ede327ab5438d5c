//! The part of observations that a base model does not absorb.
//!
//! `M = I - O Oᵀ [same group] - T Σ Tᵀ`, from the parts of an arrowhead system or, without groups, the orthonormal
//! columns `T` of a small dense one (`Σ = I`).
//!
//! Columns with a prior join the covariance ([`Projection::beside`]). `M` is then replaced by a matrix of the same
//! form with more columns `T`, which is not a projection.

mod taken;

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;
use trueaxis_leastsquares::dot;
use trueaxis_multilateration::Whitened;

pub(crate) use taken::Taken;

use crate::gram_matrix::concerned;

/// Whitened residuals and the projection that made them. Copies share the parts that are as long as the data.
#[derive(Debug, Clone)]
pub struct Projection {
    /// `e = M y`.
    pub residuals: Vec<f64>,
    /// `yᵀ M y`.
    pub squares: f64,
    /// Observations less parameters of the base model.
    pub degrees_of_freedom: f64,
    /// Effective number of columns with a prior, as far as the data determine them, `Σ x/(1 + x)`.
    pub taken: f64,
    /// Whether there are columns with a prior, so that `M² ≠ M`.
    pub is_soft: bool,
    /// The group of each row, from 0.
    pub group_of_row: Arc<Vec<usize>>,
    /// Number of groups.
    pub groups: usize,
    /// `O`, row after row.
    pub own: Arc<Vec<f64>>,
    /// Columns of `O` in each row.
    pub own_width: usize,
    /// `T`, row after row; without `Σ` its columns are orthonormal, and orthogonal to those of all groups.
    pub shared: Arc<Vec<f64>>,
    /// Columns of `T`.
    pub shared_width: usize,
    /// `Σ` of the first columns of `T`, row after row; for the others it is the identity.
    pub sigma: Arc<Vec<f64>>,
    /// Columns of `T` that have a `Σ`.
    pub sigma_width: usize,
}

/// Least share of a column that must be left for it to count as new.
const NEW_TOL: f64 = 1e-6;

impl Projection {
    /// The projection of observations without a base model.
    pub fn of_nothing(observations: Vec<f64>) -> Self {
        let rows = observations.len();
        Self {
            degrees_of_freedom: rows as f64,
            squares: dot(&observations, &observations),
            is_soft: false,
            taken: 0.0,
            residuals: observations,
            group_of_row: Arc::new(vec![0; rows]),
            groups: 1,
            own: Arc::default(),
            own_width: 0,
            shared: Arc::default(),
            shared_width: 0,
            sigma: Arc::default(),
            sigma_width: 0,
        }
    }

    /// The projection of an adjusted network.
    pub fn of_network(whitened: &Whitened) -> Self {
        Self {
            sigma: Arc::new(whitened.reduced_inverse.clone()),
            sigma_width: whitened.shared_width,
            degrees_of_freedom: whitened.degrees_of_freedom as f64,
            group_of_row: Arc::new(whitened.group_of_row.clone()),
            groups: whitened.groups,
            own: Arc::new(whitened.own.clone()),
            own_width: whitened.own_width,
            shared: Arc::new(whitened.shared.clone()),
            shared_width: whitened.shared_width,
            ..Self::of_nothing(whitened.residuals.clone())
        }
    }

    /// The projection of whitened observations `y` and the columns of a base model.
    pub fn dense(observations: Vec<f64>, base: &[Vec<f64>]) -> Self {
        Self::of_nothing(observations).extended(base)
    }

    /// The projection of several systems one below the other, each cut to its first `rows`, in units of `unit`; the
    /// other rows are observations without a base model. The systems are dense ones without groups.
    pub fn stacked<'p>(parts: impl Iterator<Item = (&'p Self, usize, f64)> + Clone) -> Self {
        let widths = parts.clone().map(|(part, ..)| part.shared_width);
        let mut stack = Self {
            own_width: widths.max().unwrap_or(0),
            groups: 0,
            ..Self::of_nothing(Vec::new())
        };
        let (mut group_of_row, mut own) = (Vec::new(), Vec::new());
        for (part, rows, unit) in parts {
            let residuals = part.residuals[..rows].iter().map(|r| r / unit);
            stack.residuals.extend(residuals);
            stack.squares += part.squares / (unit * unit);
            stack.degrees_of_freedom += part.degrees_of_freedom - (part.rows() - rows) as f64;
            stack.taken += part.taken;
            stack.is_soft |= part.is_soft;
            group_of_row.resize(stack.residuals.len(), stack.groups);
            stack.groups += 1;
            for row in 0..rows {
                let end = own.len() + stack.own_width;
                own.extend(part.shared_row(row));
                own.resize(end, 0.0);
            }
        }
        Self {
            group_of_row: Arc::new(group_of_row),
            own: Arc::new(own),
            ..stack
        }
    }

    /// `M x`: what the base model leaves of a whitened column.
    pub fn left_of(&self, column: &[f64]) -> Vec<f64> {
        let mut left = column.to_vec();
        self.project(&mut left);
        left
    }

    /// `Xᵀ e` of whitened columns.
    pub fn along(&self, columns: &[Vec<f64>]) -> Vec<f64> {
        let along = columns.iter().map(|column| dot(column, &self.residuals));
        along.collect()
    }

    /// The same projection of other whitened observations.
    pub fn with_residuals(&self, y: &[f64]) -> Self {
        let residuals = self.left_of(y);
        Self {
            squares: dot(y, &residuals),
            residuals,
            ..self.clone()
        }
    }

    /// The same projection where each observation has this much more variance than its residuals show.
    pub fn with_hidden(self, variance: f64) -> Self {
        Self {
            squares: self.squares + variance * self.degrees_of_freedom,
            ..self
        }
    }

    /// Number of observations.
    pub fn rows(&self) -> usize {
        self.residuals.len()
    }

    /// `yᵀ M y`.
    pub fn squares(&self) -> f64 {
        self.squares.max(0.0)
    }

    /// Twice the logarithm of the likelihood ratio of a model that leaves these squares, `ν ln(S/S')` with an unknown variance.
    pub fn ln_ratio(&self, squares: f64) -> f64 {
        let left = (squares / self.squares()).max(f64::MIN_POSITIVE);
        -self.degrees_of_freedom * left.ln()
    }

    /// The projection after columns have joined the base model.
    pub fn extended(&self, columns: &[Vec<f64>]) -> Self {
        let mut basis: Vec<(Range<usize>, Vec<f64>)> = Vec::new();
        let (mut residuals, mut squares) = (self.residuals.clone(), self.squares);
        for column in columns {
            let length = dot(column, column).sqrt();
            let mut left = column.clone();
            // Twice, to remove the rounding of the first time.
            for _ in 0..if self.is_soft { 1 } else { 2 } {
                let before = left.clone();
                self.project(&mut left);
                for (rows, unit) in &basis {
                    let along = dot(&unit[rows.clone()], &before[rows.clone()]);
                    add(&mut left[rows.clone()], &unit[rows.clone()], -along);
                }
            }
            // For a projection both products are equal; this one has less rounding.
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
                basis.push((concerned(&[&left]), left));
            }
        }
        if basis.is_empty() {
            return self.clone();
        }
        let width = self.shared_width + basis.len();
        let mut shared = Vec::with_capacity(self.rows() * width);
        for i in 0..self.rows() {
            shared.extend_from_slice(self.shared_row(i));
            shared.extend(basis.iter().map(|(_, unit)| unit[i]));
        }
        Self {
            degrees_of_freedom: self.degrees_of_freedom - basis.len() as f64,
            residuals,
            squares,
            shared: Arc::new(shared),
            shared_width: width,
            ..self.clone()
        }
    }

    /// Row of `O`.
    pub fn own_row(&self, row: usize) -> &[f64] {
        &self.own[row * self.own_width..(row + 1) * self.own_width]
    }

    /// Row of `T`.
    pub fn shared_row(&self, row: usize) -> &[f64] {
        &self.shared[row * self.shared_width..(row + 1) * self.shared_width]
    }

    /// Row of `Σ`, for the columns of `T` where it is not the identity.
    pub fn sigma_row(&self, row: usize) -> &[f64] {
        &self.sigma[row * self.sigma_width..(row + 1) * self.sigma_width]
    }
}

/// `X c`, for columns with `rows` rows.
pub fn combined(rows: usize, columns: &[Vec<f64>], coefficients: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (column, coefficient) in columns.iter().zip(coefficients) {
        add(&mut sum, column, *coefficient);
    }
    sum
}

/// `sum += factor · x`.
#[inline(always)]
pub fn add(sum: &mut [f64], x: &[f64], factor: f64) {
    for (s, x) in sum.iter_mut().zip(x) {
        *s += factor * x;
    }
}

/// The part of each column's length orthogonal to all columns before it, `|r_kk|` of `QR`.
pub fn lengths_beside_earlier(columns: &[Vec<f64>]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    let matrix = DMatrix::from_fn(rows, columns.len(), |i, k| columns[k][i]);
    matrix.qr().r().diagonal().iter().map(|x| x.abs()).collect()
}
