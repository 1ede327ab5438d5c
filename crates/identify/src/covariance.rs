//! Checking and whitening the covariance of the points.

use nalgebra::allocator::Allocator;
use nalgebra::{Cholesky, DMatrix, DefaultAllocator, Dim, OMatrix, OVector};

use crate::Error;

/// Largest difference between mirrored entries, relative to the standard deviations of their two
/// coordinates. Products and inverses in f64 stay far below it; a wrong index does not.
const SYMMETRY_TOL: f64 = 1e-9;

/// Least variance of a coordinate given the coordinates before it, relative to the variances that
/// the covariance is computed from. A share below it is lost in their rounding.
const CONDITIONAL_VARIANCE_TOL: f64 = 1e-12;

/// `W = L⁻¹` with `C = L Lᵀ`: W times the points' errors has unit covariance.
///
/// # Errors
/// [`Error::CovarianceShape`], [`Error::CovarianceAsymmetric`], [`Error::Covariance`].
pub(crate) fn whitening(covariance: &DMatrix<f64>, size: usize) -> Result<DMatrix<f64>, Error> {
    require_covariance(covariance, size)?;
    let l = cholesky(covariance, &covariance.diagonal())?.unpack();
    let mut w = DMatrix::identity(size, size);
    if l.solve_lower_triangular_mut(&mut w) {
        Ok(w)
    } else {
        Err(not_positive_definite(covariance))
    }
}

/// `C = L Lᵀ` for a C known to be symmetric; `variances_mm2` holds, for each of its coordinates,
/// the size of the numbers that it is computed from.
///
/// # Errors
/// [`Error::Covariance`] if C is not safely positive definite.
pub(crate) fn cholesky<D: Dim>(
    covariance: &OMatrix<f64, D, D>,
    variances_mm2: &OVector<f64, D>,
) -> Result<Cholesky<f64, D>, Error>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    let is_safe = |cholesky: &Cholesky<f64, D>| {
        let l = cholesky.l_dirty();
        (0..l.nrows()).all(|i| l[(i, i)].powi(2) > CONDITIONAL_VARIANCE_TOL * variances_mm2[i])
    };
    Cholesky::new(covariance.clone())
        .filter(is_safe)
        .ok_or_else(|| {
            let size = covariance.nrows();
            not_positive_definite(&DMatrix::from_column_slice(
                size,
                size,
                covariance.as_slice(),
            ))
        })
}

/// # Errors
/// [`Error::CovarianceShape`] or [`Error::CovarianceAsymmetric`] (also for what is not finite).
pub(crate) fn require_covariance(covariance: &DMatrix<f64>, size: usize) -> Result<(), Error> {
    let (rows, columns) = covariance.shape();
    if (rows, columns) != (size, size) {
        return Err(Error::CovarianceShape {
            rows,
            columns,
            expected: size,
        });
    }
    for column in 0..size {
        for row in 0..=column {
            let (upper, lower) = (covariance[(row, column)], covariance[(column, row)]);
            let variances = covariance[(row, row)] * covariance[(column, column)];
            let allowed = SYMMETRY_TOL * SYMMETRY_TOL * variances.abs();
            let is_symmetric = (upper - lower).powi(2) <= allowed;
            if !is_symmetric {
                return Err(Error::CovarianceAsymmetric {
                    row,
                    column,
                    upper,
                    lower,
                });
            }
        }
    }
    Ok(())
}

fn not_positive_definite(covariance: &DMatrix<f64>) -> Error {
    let eigenvalues = covariance.symmetric_eigenvalues();
    Error::Covariance {
        smallest_mm2: eigenvalues.min(),
        largest_mm2: eigenvalues.max(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(size: usize, entries: &[f64]) -> DMatrix<f64> {
        DMatrix::from_row_slice(size, size, entries)
    }

    #[test]
    fn whitened_covariance_is_the_identity() {
        let c = square(3, &[4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 0.2]);
        let w = whitening(&c, 3).unwrap();
        assert!((&w * &c * w.transpose() - DMatrix::identity(3, 3)).norm() < 1e-13);
    }

    #[test]
    fn refuses_what_is_not_positive_definite() {
        let singular = square(3, &[1.0; 9]);
        assert!(matches!(
            whitening(&singular, 3),
            Err(Error::Covariance { largest_mm2, .. }) if (largest_mm2 - 3.0).abs() < 1e-12
        ));
        let indefinite = square(2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(matches!(
            whitening(&indefinite, 2),
            Err(Error::Covariance { smallest_mm2, .. }) if (smallest_mm2 + 1.0).abs() < 1e-12
        ));
        let nearly = square(2, &[1.0, 1.0, 1.0, 1.0 + 1e-13]);
        assert!(matches!(
            whitening(&nearly, 2),
            Err(Error::Covariance { .. })
        ));
        assert!(matches!(
            whitening(&DMatrix::zeros(2, 2), 2),
            Err(Error::Covariance { .. })
        ));
    }

    #[test]
    fn refuses_what_is_no_covariance_at_all() {
        assert_eq!(
            whitening(&DMatrix::identity(9, 6), 9),
            Err(Error::CovarianceShape {
                rows: 9,
                columns: 6,
                expected: 9
            })
        );
        let mut c = DMatrix::identity(3, 3);
        c[(1, 2)] = 1e-6;
        assert_eq!(
            whitening(&c, 3),
            Err(Error::CovarianceAsymmetric {
                row: 1,
                column: 2,
                upper: 1e-6,
                lower: 0.0
            })
        );
        for wrong in [f64::NAN, f64::INFINITY] {
            c[(1, 2)] = 0.0;
            c[(0, 0)] = wrong;
            assert!(matches!(
                whitening(&c, 3),
                Err(Error::CovarianceAsymmetric {
                    row: 0,
                    column: 0,
                    ..
                })
            ));
        }
    }
}
