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

use nalgebra::DMatrix;
use trueaxis_multilateration::{LengthNoise, Screened};

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
    fn group(&self, group: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let (own, coupling) = match &self.source {
            NoiseSource::Adjusted(screened) => {
                let covariance = &screened.solution.covariance;
                let factor = dense(covariance.inverse_factor(group));
                (
                    &factor * factor.transpose(),
                    dense(covariance.coupling(group)),
                )
            }
            NoiseSource::Lengths(noise) => noise.group(group),
            NoiseSource::Independent(blocks) => {
                let own = blocks[group].clone();
                let rows = own.nrows();
                (own, DMatrix::zeros(rows, 0))
            }
        };
        (own * self.variance_factor, coupling)
    }

    /// `D` and `Z` of a record's points, in the order of its targets.
    pub(crate) fn of_record(&self, record: &Record) -> (DMatrix<f64>, DMatrix<f64>) {
        let (own, coupling) = self.group(record.group);
        if record.has_whole_group(own.nrows() / 3) {
            return (own, coupling);
        }
        (select_targets(&own, record), select_rows(&coupling, record))
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
        let (own, coupling) = self.group(group);
        let total = own + &coupling * self.shared() * coupling.transpose();
        // Symmetric to the last bit, as the identification asks.
        (&total + total.transpose()) * 0.5
    }
}

fn dense(matrix: faer::MatRef<'_, f64>) -> DMatrix<f64> {
    let elements = matrix.col_iter().flat_map(|column| column.iter());
    DMatrix::from_iterator(matrix.nrows(), matrix.ncols(), elements.copied())
}
