//! Checking the covariance of the points.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::Error;

/// Largest difference between mirrored entries, relative to the standard deviations of their two
/// coordinates. Products and inverses in f64 stay far below it; a wrong index does not.
const SYMMETRY_TOL: f64 = 1e-9;

/// Least variance of a coordinate given the coordinates before it, relative to the variances from which the
/// covariance is computed: a smaller one is lost in rounding.
const CONDITIONAL_VARIANCE_TOL: f64 = 1e-12;

/// `C = L Lᵀ` for a C known to be symmetric; `variances_mm2` holds, for each of its coordinates, the size of the
/// numbers from which it is computed.
///
/// # Errors
/// [`Error::Covariance`] if C is not safely positive definite.
pub(crate) fn cholesky(
    covariance: &DMatrix<f64>,
    variances_mm2: &DVector<f64>,
) -> Result<Cholesky<f64, Dyn>, Error> {
    let is_safe = |cholesky: &Cholesky<f64, Dyn>| {
        let l = cholesky.l_dirty();
        (0..l.nrows()).all(|i| l[(i, i)].powi(2) > CONDITIONAL_VARIANCE_TOL * variances_mm2[i])
    };
    Cholesky::new(covariance.clone())
        .filter(is_safe)
        .ok_or_else(|| {
            let eigenvalues = covariance.symmetric_eigenvalues();
            Error::Covariance {
                smallest_mm2: eigenvalues.min(),
                largest_mm2: eigenvalues.max(),
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn square(size: usize, entries: &[f64]) -> DMatrix<f64> {
        DMatrix::from_row_slice(size, size, entries)
    }

    fn refusal(c: &DMatrix<f64>) -> Option<Error> {
        cholesky(c, &c.diagonal()).err()
    }

    #[test]
    fn refuses_what_is_not_positive_definite() {
        let singular = square(3, &[1.0; 9]);
        assert!(matches!(
            refusal(&singular),
            Some(Error::Covariance { largest_mm2, .. }) if (largest_mm2 - 3.0).abs() < 1e-12
        ));
        let indefinite = square(2, &[1.0, 2.0, 2.0, 1.0]);
        assert!(matches!(
            refusal(&indefinite),
            Some(Error::Covariance { smallest_mm2, .. }) if (smallest_mm2 + 1.0).abs() < 1e-12
        ));
        let nearly = square(2, &[1.0, 1.0, 1.0, 1.0 + 1e-13]);
        assert!(matches!(refusal(&nearly), Some(Error::Covariance { .. })));
        assert!(matches!(
            refusal(&DMatrix::zeros(2, 2)),
            Some(Error::Covariance { .. })
        ));
    }

    #[test]
    fn refuses_what_is_no_covariance_at_all() {
        assert_eq!(
            require_covariance(&DMatrix::identity(9, 6), 9),
            Err(Error::CovarianceShape {
                rows: 9,
                columns: 6,
                expected: 9
            })
        );
        let mut c = DMatrix::identity(3, 3);
        c[(1, 2)] = 1e-6;
        assert_eq!(
            require_covariance(&c, 3),
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
                require_covariance(&c, 3),
                Err(Error::CovarianceAsymmetric {
                    row: 0,
                    column: 0,
                    ..
                })
            ));
        }
    }
}
