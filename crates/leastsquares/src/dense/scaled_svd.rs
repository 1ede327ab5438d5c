//! Singular values of a matrix with scaled columns, `A D⁻¹ = U Σ Vᵀ`.

use nalgebra::DMatrix;

use super::linearised::norm;
use super::svd::Svd;
use crate::Error;

/// The decomposition and the scale of the columns. Its *components* are coordinates in the
/// columns of `U` (or `V`), one for each singular value.
#[derive(Debug)]
pub(super) struct ScaledSvd {
    scale: Vec<f64>,
    svd: Svd,
}

impl ScaledSvd {
    /// Every column divided by its own length; a column of zeros stays.
    pub(super) fn unit_columns(matrix: &DMatrix<f64>) -> Result<Self, Error> {
        Self::new(matrix, column_lengths(matrix))
    }

    /// Every column divided by its scale; those of scale zero stay.
    pub(super) fn new(matrix: &DMatrix<f64>, mut scale: Vec<f64>) -> Result<Self, Error> {
        for scale in scale.iter_mut().filter(|scale| **scale <= 0.0) {
            *scale = 1.0;
        }
        let mut scaled = matrix.clone();
        for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
            column /= *scale;
        }
        let svd = Svd::new(&scaled)?;
        Ok(Self { scale, svd })
    }

    /// Largest first.
    pub(super) fn singular_values(&self) -> &[f64] {
        &self.svd.values
    }

    /// The least singular value relative to the largest; zero if there are fewer rows than
    /// columns.
    pub(super) fn least_singular_value(&self) -> f64 {
        let (values, largest) = (self.singular_values(), self.svd.largest());
        match values.last() {
            Some(least) if values.len() == self.scale.len() && largest > 0.0 => least / largest,
            _ => 0.0,
        }
    }

    /// Singular values above `tol` times the largest.
    pub(super) fn rank(&self, tol: f64) -> usize {
        self.svd.rank(tol * self.svd.largest())
    }

    /// For each unknown its share (0 to 1) in the combinations beyond the first `rank`.
    pub(super) fn free_shares(&self, rank: usize) -> Vec<f64> {
        // A wide matrix has free combinations that the thin decomposition does not list.
        let v = &self.svd.v;
        (0..self.scale.len())
            .map(|i| 1.0 - (0..rank).map(|k| v[(i, k)] * v[(i, k)]).sum::<f64>())
            .collect()
    }

    /// `Uᵀ y`
    pub(super) fn row_components(&self, rows: &[f64]) -> Vec<f64> {
        let u = &self.svd.u;
        (0..self.singular_values().len())
            .map(|k| (0..rows.len()).map(|i| u[(i, k)] * rows[i]).sum())
            .collect()
    }

    /// Components of a change of the unknowns to the unknowns, `D⁻¹ V z`.
    pub(super) fn unknowns(&self, components: &[f64]) -> Vec<f64> {
        let v = &self.svd.v;
        let unknown = |i: usize| -> f64 {
            (0..components.len())
                .map(|k| v[(i, k)] * components[k])
                .sum()
        };
        (0..self.scale.len())
            .map(|i| unknown(i) / self.scale[i])
            .collect()
    }

    /// Components of a gradient by the unknowns, `Vᵀ D⁻¹ g`.
    pub(super) fn gradient_components(&self, gradient: &[f64]) -> Vec<f64> {
        let v = &self.svd.v;
        (0..self.singular_values().len())
            .map(|k| {
                (0..gradient.len())
                    .map(|i| v[(i, k)] * gradient[i] / self.scale[i])
                    .sum()
            })
            .collect()
    }

    /// `A⁺ y` at full column rank.
    pub(super) fn solve(&self, rows: &[f64]) -> Vec<f64> {
        let mut components = self.row_components(rows);
        for (c, s) in components.iter_mut().zip(self.singular_values()) {
            *c /= s;
        }
        self.unknowns(&components)
    }

    /// `(AᵀA)⁻¹` at full column rank.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        let (v, s, scale) = (&self.svd.v, self.singular_values(), &self.scale);
        DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
            let sum: f64 = (0..s.len())
                .map(|k| v[(i, k)] * v[(j, k)] / (s[k] * s[k]))
                .sum();
            sum / (scale[i] * scale[j])
        })
    }
}

pub(super) fn column_lengths(matrix: &DMatrix<f64>) -> Vec<f64> {
    let columns = matrix.column_iter();
    columns.map(|column| norm(column.as_slice())).collect()
}
