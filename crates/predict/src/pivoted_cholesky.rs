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

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without a pattern, -1 to 1.
    fn factor(rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |i, j| {
            (1.7 * (i * i + 5 * j * i + 3 * j) as f64 + 0.3).sin()
        })
    }

    #[test]
    fn the_factor_gives_the_covariance_with_as_many_columns_as_its_rank() {
        for (rows, rank) in [(7, 7), (9, 4), (5, 1), (4, 0)] {
            let covariance = match rank {
                0 => DMatrix::zeros(rows, rows),
                _ => factor(rows, rank) * factor(rows, rank).transpose(),
            };
            let columns = pivoted_cholesky(&covariance, 1e-12);
            assert_eq!(columns.len(), rank);
            let product =
                |sum: DMatrix<f64>, column: &DVector<f64>| sum + column * column.transpose();
            let product = columns.iter().fold(DMatrix::zeros(rows, rows), product);
            assert!((product - covariance).amax() < 1e-13);
        }
    }

    #[test]
    fn what_is_left_is_below_the_limit() {
        let covariance = factor(12, 12) * factor(12, 12).transpose();
        let columns = pivoted_cholesky(&covariance, 0.5);
        assert!(!columns.is_empty() && columns.len() < 12);
        for i in 0..12 {
            let left: f64 = covariance[(i, i)] - columns.iter().map(|c| c[i] * c[i]).sum::<f64>();
            assert!((-1e-12..=0.5).contains(&left), "{left}");
        }
    }
}
