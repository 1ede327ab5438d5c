//! Decompositions that are asked for elsewhere. Generic code is compiled wherever it is called; here it is compiled once.

use nalgebra::{DMatrix, SymmetricEigen};

use super::svd::Svd;
use crate::Error;

/// Eigenvalues, in any order, with an orthonormal eigenvector each, of a symmetric matrix of which the lower triangle is
/// read.
///
/// # Errors
/// [`Error::Decomposition`] if an element is not finite.
pub fn symmetric_eigen(matrix: DMatrix<f64>) -> Result<SymmetricEigen<f64, nalgebra::Dyn>, Error> {
    match matrix.iter().all(|x| x.is_finite()) {
        true => Ok(matrix.symmetric_eigen()),
        false => Err(Error::Decomposition {
            what: "eigenvalue decomposition",
        }),
    }
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
