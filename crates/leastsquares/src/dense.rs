//! Least squares with a small full design matrix: [`solve`] where the rows are linear in the
//! unknowns, [`adjust`] where they are not.
//!
//! Columns are scaled to unit length, the rank is read from the singular values, and a deficient
//! design is refused with the unknowns that are free.

mod adjust;
mod curvature;
mod decompositions;
mod eigenvalues_along;
mod linearised;
mod model;
mod residual;
mod scaled_svd;
mod svd;
mod termination;
mod trust_region;

use nalgebra::DMatrix;

pub use adjust::{Adjusted, adjust};
pub use decompositions::{relative_singular_value, symmetric_eigen};
pub use eigenvalues_along::eigenvalues_along;
pub use model::Model;
pub use svd::Svd;
pub use termination::Termination;

use crate::Error;
use residual::twofold_residual;
use scaled_svd::ScaledSvd;

/// Solution of `min |y - A x|` with the evidence.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The unknowns.
    pub unknowns: Vec<f64>,
    /// `y - A x`.
    pub residuals: Vec<f64>,
    /// Covariance of the unknowns for unit variance of the rows, `(AᵀA)⁻¹`.
    pub covariance: DMatrix<f64>,
    /// Singular values of the design with unit columns, largest first.
    pub singular_values: Vec<f64>,
}

/// Relative singular value below which a combination of unknowns counts as free: f64 leaves no
/// correct digit of the solution of a design worse than this.
pub const RANK_TOL: f64 = 1e-13;

/// Solves `min |y - A x|` for whitened rows.
///
/// The solution is corrected once by the residuals of twofold precision: what is left of its error
/// is what the rounding of `design` and `right_side` to f64 has done before.
///
/// # Errors
/// [`Error::DenseRank`] if `design` does not have full column rank, [`Error::NotFinite`].
///
/// # Panics
/// If `right_side` does not have one element for each row.
pub fn solve(design: &DMatrix<f64>, right_side: &[f64]) -> Result<Fit, Error> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    assert_eq!(right_side.len(), rows, "one right-hand side for each row");
    let finite = design.iter().chain(right_side).all(|x| x.is_finite());
    if !finite {
        return Err(Error::NotFinite {
            what: "the design matrix or its right-hand side",
        });
    }
    let svd = ScaledSvd::unit_columns(design)?;
    let rank = svd.rank(RANK_TOL);
    if rank < unknowns {
        return Err(Error::DenseRank {
            rank,
            unknowns,
            singular_value: svd.least_singular_value(),
            limit: RANK_TOL,
            free: svd.free_shares(rank),
        });
    }
    let mut solution = svd.solve(right_side);
    let correction = svd.solve(&twofold_residual(design, &solution, right_side));
    for (x, change) in solution.iter_mut().zip(correction) {
        *x += change;
    }
    Ok(Fit {
        residuals: twofold_residual(design, &solution, right_side),
        unknowns: solution,
        covariance: svd.covariance(),
        singular_values: svd.singular_values().to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_correction_removes_the_error_of_the_decomposition() {
        // Powers up to 12⁷ and their sums are exact in f64; the solution is one throughout. The
        // condition with unit columns is 2e5: the decomposition alone leaves errors of 1e-8 in
        // the unknowns that contribute least.
        let design = DMatrix::from_fn(12, 8, |i, j| (0..j).fold(1.0, |p, _| p * (i + 1) as f64));
        let right_side: Vec<f64> = design.column_sum().as_slice().to_vec();
        let fit = solve(&design, &right_side).unwrap();
        assert!(fit.unknowns.iter().all(|x| (x - 1.0).abs() < 1e-14));
    }

    #[test]
    fn names_the_free_unknowns() {
        let design = DMatrix::from_fn(4, 3, |i, j| {
            let x = [1.0, 2.0, 4.0, 7.0][i];
            [1.0, x, 3.0 * x][j]
        });
        let Err(Error::DenseRank { rank: 2, free, .. }) = solve(&design, &[0.0; 4]) else {
            panic!("a dependent column must be refused");
        };
        assert!(
            free[0] < 1e-12 && free[1] > 0.4 && free[2] > 0.4,
            "{free:?}"
        );
    }

    #[test]
    fn refuses_numbers_that_are_not() {
        let design = DMatrix::from_fn(2, 1, |_, _| f64::NAN);
        assert_eq!(
            solve(&design, &[0.0; 2]).unwrap_err(),
            Error::NotFinite {
                what: "the design matrix or its right-hand side"
            }
        );
    }
}
