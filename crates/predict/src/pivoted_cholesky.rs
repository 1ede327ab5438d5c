//! The directions of a covariance that may be singular.

use nalgebra::{DMatrix, DVector};

/// Columns `L` with `K ≈ L Lᵀ` of a covariance `K` (square, symmetric), the largest variance that is left first; no diagonal element
/// of the rest exceeds `limit`, in the unit of `K` (Cholesky's factorisation with pivoting).
pub fn pivoted_cholesky(mut rest: DMatrix<f64>, limit: f64) -> Vec<DVector<f64>> {
    let mut columns = Vec::new();
    for _ in 0..rest.nrows() {
        let (pivot, largest) = rest.diagonal().argmax();
        if largest <= limit || largest.is_nan() {
            break;
        }
        let column = rest.column(pivot) / largest.sqrt();
        rest -= &column * column.transpose();
        columns.push(column);
    }
    columns
}
