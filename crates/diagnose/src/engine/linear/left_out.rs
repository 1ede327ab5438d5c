//! Readings that are left out, predicted by the rest without a further adjustment.
//!
//! With `T` the orthonormal columns of a model and `e` what it leaves of an observation vector, the prediction errors
//! of the readings `h` are
//!
//! ```text
//! y_h - ŷ_h = (I - T_h T_hᵀ)⁻¹ e_h = e_h + T_h (I - T_hᵀ T_h)⁻¹ T_hᵀ e_h
//! ```
//!
//! exactly as if the model had been fitted to the rest. Readings whose prediction would need unknowns that only they
//! determine have none.

use nalgebra::{DMatrix, DVector, SymmetricEigen};
use trueaxis_selection::Projection;

/// Least share of an unknown that the rest must determine.
const DETERMINED: f64 = 1e-8;

/// A model without some of its rows.
pub(crate) struct LeftOut {
    pub(crate) rows: Vec<usize>,
    /// `T_h` along eigenvectors of `I - T_hᵀ T_h` that the rest determines, and their eigenvalues; then along others.
    along: Vec<(DVector<f64>, f64)>,
    only_here: Vec<(DVector<f64>, f64)>,
}

impl LeftOut {
    pub(crate) fn new(model: &Projection, rows: Vec<usize>) -> Self {
        let width = model.shared_width;
        let t = DMatrix::from_fn(rows.len(), width, |i, k| model.shared_row(rows[i])[k]);
        // `T_hᵀ T_h` and `T_h T_hᵀ` have the same eigenvalues but zeros: the smaller one.
        let few = rows.len() < width;
        let squares = match few {
            true => &t * t.transpose(),
            false => t.tr_mul(&t),
        };
        let size = squares.nrows();
        let eigen = SymmetricEigen::new(DMatrix::identity(size, size) - squares);
        let values = eigen.eigenvalues.iter().copied();
        let turned = match few {
            true => eigen.eigenvectors,
            false => &t * eigen.eigenvectors,
        };
        let all = turned.column_iter().zip(values).map(|(column, value)| {
            let length = match few {
                true => (1.0 - value).max(0.0).sqrt(),
                false => 1.0,
            };
            (column * length, value)
        });
        let (along, only_here) = all.partition(|(_, value)| *value >= DETERMINED);
        Self {
            rows,
            along,
            only_here,
        }
    }

    /// Prediction errors from what the model leaves of a vector over all rows (its projection).
    pub(crate) fn errors(&self, projected: &[f64]) -> Vec<f64> {
        let e: Vec<f64> = self.rows.iter().map(|&row| projected[row]).collect();
        let mut errors = e.clone();
        for (column, value) in &self.along {
            let product: f64 = column.iter().zip(&e).map(|(c, e)| c * e).sum();
            for (error, c) in errors.iter_mut().zip(column) {
                *error += c * product / value;
            }
        }
        errors
    }

    /// Part of the rows in the inner product of two projected vectors, one of them given by its prediction errors.
    pub(crate) fn product(&self, errors: &[f64], projected: &[f64]) -> f64 {
        let rows = self.rows.iter().zip(errors);
        rows.map(|(&row, error)| error * projected[row]).sum()
    }

    /// The errors of those rows that the rest predicts; `None` for the others.
    pub(crate) fn determined(&self, errors: Vec<f64>) -> Vec<Option<f64>> {
        let is_determined = |i: usize| {
            let mut only_here = self.only_here.iter();
            only_here.all(|(column, _)| column[i] * column[i] <= DETERMINED)
        };
        let errors = errors.into_iter().enumerate();
        errors
            .map(|(i, error)| is_determined(i).then_some(error))
            .collect()
    }

    /// Variances of the errors where the noise has variance one.
    pub(crate) fn expected(&self) -> Vec<f64> {
        let mut expected = vec![1.0; self.rows.len()];
        for (column, value) in &self.along {
            for (sum, c) in expected.iter_mut().zip(column) {
                *sum += c * c / value;
            }
        }
        expected
    }
}
