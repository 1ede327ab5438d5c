//! The errors of measured points: a part of its own for each group and a part that all share.
//!
//! ```text
//! dp_i = ξ_i - Z_i s     cov(ξ_i) = D_i, independent between groups     cov(s) = Σ
//! ```
//!
//! For lengths the shared sources `s` are the errors of stations and dead paths (first) and of the
//! datum; `D_i` is the covariance of the points with all stations known. This form holds for the
//! whole noise and for the instrument's own part of it alone, so both are propagated alike.

use std::sync::Arc;

use faer::MatRef;
use nalgebra::DMatrix;
use trueaxis_multilateration::{GroupNoise, LengthNoise, Screened};

use crate::axis_data::Record;
use crate::records::{select_rows, select_targets};

/// Covariance of the measured points, mm².
pub(crate) struct PointNoise<'a> {
    pub(crate) source: NoiseSource<'a>,
    /// Factor on all variances.
    pub(crate) variance_factor: f64,
}

pub(crate) enum NoiseSource<'a> {
    /// From the adjustment of lengths.
    Adjusted(Arc<Screened>),
    /// The lengths' own noise alone.
    Lengths(Box<LengthNoise<'a>>),
    /// Independent groups with these covariances.
    Independent(Vec<DMatrix<f64>>),
}

impl PointNoise<'_> {
    /// `D` and `Z` of a group.
    fn group(&self, group: usize, errors: &mut GroupNoise) {
        match &self.source {
            NoiseSource::Adjusted(screened) => {
                let covariance = &screened.solution.covariance;
                square_of_upper(covariance.inverse_factor(group), &mut errors.own);
                let z = covariance.coupling(group);
                errors.coupling.resize_mut(z.nrows(), z.ncols(), 0.0);
                errors
                    .coupling
                    .copy_from_slice(covariance.coupling_columns(group));
            }
            NoiseSource::Lengths(noise) => noise.group(group, errors),
            NoiseSource::Independent(blocks) => {
                errors.own.clone_from(&blocks[group]);
                errors.coupling.resize_mut(blocks[group].nrows(), 0, 0.0);
            }
        }
        errors.own *= self.variance_factor;
    }

    /// `D` and `Z` of a record's points, in the order of its targets; `errors` is memory to work
    /// in.
    pub(crate) fn of_record<'m>(
        &self,
        record: &Record,
        errors: &'m mut GroupNoise,
    ) -> (&'m DMatrix<f64>, &'m DMatrix<f64>) {
        self.group(record.group, errors);
        if !record.has_whole_group(errors.own.nrows() / 3) {
            errors.own = select_targets(&errors.own, record);
            errors.coupling = select_rows(&errors.coupling, record);
        }
        (&errors.own, &errors.coupling)
    }

    /// `Σ`. It is indefinite and makes sense only between couplings, but for the stations.
    pub(crate) fn shared(&self) -> DMatrix<f64> {
        let unscaled = match &self.source {
            NoiseSource::Adjusted(screened) => {
                dense(screened.solution.covariance.reduced_inverse())
            }
            NoiseSource::Lengths(noise) => dense(noise.shared().as_ref()),
            NoiseSource::Independent(_) => DMatrix::zeros(0, 0),
        };
        unscaled * self.variance_factor
    }

    /// `D_i + Z_i Σ Z_iᵀ` of a group.
    pub(crate) fn total(&self, group: usize) -> DMatrix<f64> {
        let mut errors = GroupNoise::default();
        self.group(group, &mut errors);
        let GroupNoise { own, coupling, .. } = errors;
        let total = own + &coupling * self.shared() * coupling.transpose();
        // Symmetric to the last bit, as the identification asks.
        (&total + total.transpose()) * 0.5
    }
}

/// `R Rᵀ` for an upper triangular `R`.
fn square_of_upper(factor: MatRef<'_, f64>, square: &mut DMatrix<f64>) {
    let size = factor.ncols();
    square.resize_mut(size, size, 0.0);
    square.fill(0.0);
    for (k, column) in factor.col_iter().enumerate() {
        for (j, x) in column.iter().enumerate().take(k + 1) {
            let sums = &mut square.as_mut_slice()[j * size..j * size + k + 1];
            for (sum, y) in sums.iter_mut().zip(column.iter()) {
                *sum += x * y;
            }
        }
    }
}

fn dense(matrix: MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
