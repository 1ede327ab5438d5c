//! Decompositions of dense matrices.
//!
//! They are faer's, which are generic: every crate that calls faer compiles them again. Here they are compiled once.

use faer::linalg::solvers::DenseSolveCore;
use faer::{Mat, MatRef, Side};

use crate::Error;

/// Eigenvalues in ascending order, with an orthonormal eigenvector each, of a symmetric matrix.
#[derive(Debug, Clone)]
pub struct SymmetricEigen {
    /// In ascending order.
    pub values: Vec<f64>,
    /// One in each column.
    pub vectors: Mat<f64>,
}

/// Of a symmetric matrix, of which the lower triangle is read.
///
/// # Errors
/// [`Error::Decomposition`] if the iteration does not converge.
pub fn symmetric_eigen(matrix: MatRef<'_, f64>) -> Result<SymmetricEigen, Error> {
    let eigen = matrix
        .self_adjoint_eigen(Side::Lower)
        .map_err(|_| Error::Decomposition {
            what: "eigenvalue decomposition",
        })?;
    Ok(SymmetricEigen {
        values: eigen.S().column_vector().iter().copied().collect(),
        vectors: eigen.U().to_owned(),
    })
}

/// The least singular value over the largest; zero where that has no meaning.
#[must_use]
pub fn relative_singular_value(matrix: MatRef<'_, f64>) -> f64 {
    let values = matrix.singular_values().unwrap_or_default();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    if largest > 0.0 {
        smallest / largest
    } else {
        0.0
    }
}

/// Of a square matrix, by elimination with row exchanges; not finite if the matrix is singular.
#[must_use]
pub fn inverse(matrix: MatRef<'_, f64>) -> Mat<f64> {
    matrix.partial_piv_lu().inverse()
}
