//! Decompositions that are asked for elsewhere. Generic code is compiled wherever it is called; here it is compiled once.

use nalgebra::{DMatrix, DVector, Dyn, SymmetricEigen};

use super::svd::Svd;
use crate::Error;

/// Steps for each eigenvalue; two or three are usual.
pub(super) const STEPS: usize = 100;

/// Eigenvalues, in any order, with an orthonormal eigenvector each, of a symmetric matrix of which the lower triangle is
/// read.
///
/// # Errors
/// [`Error::Decomposition`] if an element is not finite, or the iteration does not converge.
pub fn symmetric_eigen(matrix: DMatrix<f64>) -> Result<SymmetricEigen<f64, Dyn>, Error> {
    if matrix.is_empty() {
        return Ok(SymmetricEigen {
            eigenvectors: matrix,
            eigenvalues: DVector::zeros(0),
        });
    }
    let steps = STEPS * matrix.nrows();
    let is_finite = matrix.iter().all(|x| x.is_finite());
    let eigen = is_finite.then(|| SymmetricEigen::try_new(matrix, f64::EPSILON, steps));
    eigen.flatten().ok_or(Error::Decomposition {
        what: "eigenvalue decomposition",
    })
}

/// The least singular value over the largest; zero where that has no meaning.
#[must_use]
pub fn relative_singular_value(matrix: &DMatrix<f64>) -> f64 {
    let values = Svd::new(matrix).map(|svd| svd.values).unwrap_or_default();
    match (values.first(), values.last()) {
        (Some(&largest), Some(least)) if largest > 0.0 => least / largest,
        _ => 0.0,
    }
}
