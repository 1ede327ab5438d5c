//! Least squares with a small full design matrix.
//!
//! Columns are scaled to unit length, the rank is read from the singular values, and a deficient
//! design is refused with the unknowns that are free.

use faer::{Mat, MatRef};

use crate::Error;

/// Solution of `min |y - A x|` with the evidence.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The unknowns.
    pub unknowns: Vec<f64>,
    /// `y - A x`.
    pub residuals: Vec<f64>,
    /// Covariance of the unknowns for unit variance of the rows, `(AᵀA)⁻¹`.
    pub covariance: Mat<f64>,
    /// Singular values of the design with unit columns, largest first.
    pub singular_values: Vec<f64>,
}

/// Relative singular value below which a combination of unknowns counts as free: f64 leaves no
/// correct digit of the solution of a design worse than this.
pub const RANK_TOL: f64 = 1e-13;

/// Solves `min |y - A x|` for whitened rows.
///
/// # Errors
/// [`Error::DenseRank`] if `design` does not have full column rank, [`Error::NotFinite`].
///
/// # Panics
/// If `right_side` does not have one element for each row.
pub fn solve(design: MatRef<'_, f64>, right_side: &[f64]) -> Result<Fit, Error> {
    let (rows, unknowns) = (design.nrows(), design.ncols());
    assert_eq!(right_side.len(), rows, "one right-hand side for each row");
    let finite = (0..unknowns).all(|j| design.col(j).iter().all(|x| x.is_finite()))
        && right_side.iter().all(|x| x.is_finite());
    if !finite {
        return Err(Error::NotFinite {
            what: "the design matrix or its right-hand side",
        });
    }
    let lengths: Vec<f64> = (0..unknowns)
        .map(|j| design.col(j).norm_l2())
        .map(|length| if length > 0.0 { length } else { 1.0 })
        .collect();
    let scaled = Mat::from_fn(rows, unknowns, |i, j| design[(i, j)] / lengths[j]);
    let svd = scaled.thin_svd().map_err(|_| Error::Decomposition {
        what: "singular value decomposition",
    })?;
    let singular_values: Vec<f64> = svd.S().column_vector().iter().copied().collect();
    let largest = singular_values.first().copied().unwrap_or(0.0);
    let rank = singular_values
        .iter()
        .filter(|&&s| s > RANK_TOL * largest)
        .count();
    let v = svd.V();
    if rank < unknowns {
        // A wide design has free combinations that the thin decomposition does not list.
        let free = (0..unknowns)
            .map(|i| 1.0 - (0..rank).map(|k| v[(i, k)] * v[(i, k)]).sum::<f64>())
            .collect();
        let last = if rows < unknowns {
            0.0
        } else {
            singular_values[unknowns - 1]
        };
        let singular_value = if largest > 0.0 { last / largest } else { 0.0 };
        return Err(Error::DenseRank {
            rank,
            unknowns,
            singular_value,
            limit: RANK_TOL,
            free,
        });
    }
    let coefficients: Vec<f64> = (0..unknowns)
        .map(|k| {
            let projected: f64 = (0..rows).map(|i| svd.U()[(i, k)] * right_side[i]).sum();
            projected / singular_values[k]
        })
        .collect();
    let solution: Vec<f64> = (0..unknowns)
        .map(|i| {
            (0..unknowns)
                .map(|k| v[(i, k)] * coefficients[k])
                .sum::<f64>()
                / lengths[i]
        })
        .collect();
    let residuals = (0..rows)
        .map(|i| {
            right_side[i]
                - (0..unknowns)
                    .map(|j| design[(i, j)] * solution[j])
                    .sum::<f64>()
        })
        .collect();
    let covariance = Mat::from_fn(unknowns, unknowns, |i, j| {
        let sum: f64 = (0..unknowns)
            .map(|k| v[(i, k)] * v[(j, k)] / (singular_values[k] * singular_values[k]))
            .sum();
        sum / (lengths[i] * lengths[j])
    });
    Ok(Fit {
        unknowns: solution,
        residuals,
        covariance,
        singular_values,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_line_through_three_points() {
        let design = Mat::from_fn(3, 2, |i, j| if j == 0 { 1.0 } else { [0.0, 1.0, 2.0][i] });
        let fit = solve(design.as_ref(), &[1.0, 3.0, 5.0]).unwrap();
        assert!((fit.unknowns[0] - 1.0).abs() < 1e-14 && (fit.unknowns[1] - 2.0).abs() < 1e-14);
        assert!((fit.covariance[(1, 1)] - 0.5).abs() < 1e-14);
    }

    #[test]
    fn names_the_free_unknowns() {
        let design = Mat::from_fn(4, 3, |i, j| {
            let x = [1.0, 2.0, 4.0, 7.0][i];
            [1.0, x, 3.0 * x][j]
        });
        let Err(Error::DenseRank { rank: 2, free, .. }) = solve(design.as_ref(), &[0.0; 4]) else {
            panic!("a dependent column must be refused");
        };
        assert!(
            free[0] < 1e-12 && free[1] > 0.4 && free[2] > 0.4,
            "{free:?}"
        );
    }

    #[test]
    fn refuses_numbers_that_are_not() {
        let design = Mat::from_fn(2, 1, |_, _| f64::NAN);
        assert_eq!(
            solve(design.as_ref(), &[0.0; 2]).unwrap_err(),
            Error::NotFinite {
                what: "the design matrix or its right-hand side"
            }
        );
    }
}
