//! The directions of a covariance that may be singular.

use nalgebra::{DMatrix, DVector};

/// Columns `L` with `K ≈ L Lᵀ` of a covariance `K` (square, symmetric), the largest variance that is left first; no diagonal element
/// of the rest exceeds `limit`, in the unit of `K` (Cholesky's factorisation with pivoting).
pub fn pivoted_cholesky(covariance: &DMatrix<f64>, limit: f64) -> Vec<DVector<f64>> {
    let mut columns: Vec<DVector<f64>> = Vec::new();
    let mut left = covariance.diagonal();
    for _ in 0..covariance.nrows() {
        let (pivot, largest) = left.argmax();
        if largest <= limit || largest.is_nan() {
            break;
        }
        let mut column = covariance.column(pivot).into_owned();
        for before in &columns {
            column.axpy(-before[pivot], before, 1.0);
        }
        column /= largest.sqrt();
        left.zip_apply(&column, |variance, x| *variance -= x * x);
        left[pivot] = 0.0;
        columns.push(column);
    }
    columns
}
