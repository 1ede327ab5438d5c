//! `xᵀ A x`.

use faer::Mat;

/// `xᵀ A x` for a small square matrix.
pub(crate) fn quadratic_form(matrix: &Mat<f64>, x: &[f64]) -> f64 {
    (0..x.len())
        .map(|j| x[j] * (0..x.len()).map(|i| matrix[(i, j)] * x[i]).sum::<f64>())
        .sum()
}
