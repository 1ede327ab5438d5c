//! Points with their covariance, from lengths or from coordinates.
//!
//! Their error is a part of its own for each group and a part that all share:
//! `dp_i = ξ_i - Z_i s` with `cov(ξ_i) = D_i` independent between groups and `cov(s) = Σ`.

use std::ops::Range;

use nalgebra::{DMatrix, Point3};
use trueaxis_campaign::Direction;
use trueaxis_leastsquares::Covariance;

/// All measured points in the datum: best fit to their nominal positions.
pub(crate) struct Measured {
    pub(crate) groups: Vec<MeasuredGroup>,
    pub(crate) points_mm: Vec<Point3<f64>>,
    pub(crate) noise: PointNoise,
    /// Scatter of repeated points about their means in units of the declared variance, and its
    /// degrees of freedom; nothing where lengths were measured, whose repeats the adjustment tests.
    pub(crate) repeat_scatter: (f64, usize),
}

/// The targets of one step.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredGroup {
    pub(crate) step: usize,
    pub(crate) direction: Option<Direction>,
    pub(crate) targets: Vec<usize>,
    pub(crate) points: Range<usize>,
}

/// Covariance of the measured points, mm².
pub(crate) struct PointNoise {
    pub(crate) source: NoiseSource,
    /// Factor on all variances.
    pub(crate) variance_factor: f64,
}

pub(crate) enum NoiseSource {
    /// From the adjustment of lengths; blocks are the groups.
    Adjusted(Covariance),
    /// Independent groups with these covariances.
    Independent(Vec<DMatrix<f64>>),
}

impl PointNoise {
    /// `D_i`.
    pub(crate) fn own(&self, group: usize) -> DMatrix<f64> {
        let unscaled = match &self.source {
            NoiseSource::Adjusted(covariance) => {
                dense(covariance.block_given_shared(group).as_ref())
            }
            NoiseSource::Independent(blocks) => blocks[group].clone(),
        };
        unscaled * self.variance_factor
    }

    /// `Z_i`.
    pub(crate) fn coupling(&self, group: usize) -> DMatrix<f64> {
        match &self.source {
            NoiseSource::Adjusted(covariance) => dense(covariance.coupling(group)),
            NoiseSource::Independent(blocks) => DMatrix::zeros(blocks[group].nrows(), 0),
        }
    }

    /// `Σ`.
    pub(crate) fn shared(&self) -> DMatrix<f64> {
        match &self.source {
            NoiseSource::Adjusted(covariance) => {
                dense(covariance.reduced_inverse()) * self.variance_factor
            }
            NoiseSource::Independent(_) => DMatrix::zeros(0, 0),
        }
    }

    /// Width of `Z`: number of shared sources.
    pub(crate) fn shared_sources(&self) -> usize {
        match &self.source {
            NoiseSource::Adjusted(covariance) => covariance.reduced_inverse().ncols(),
            NoiseSource::Independent(_) => 0,
        }
    }

    /// `D_i + Z_i Σ Z_iᵀ`.
    pub(crate) fn total(&self, group: usize) -> DMatrix<f64> {
        let unscaled = match &self.source {
            NoiseSource::Adjusted(covariance) => dense(covariance.block(group).as_ref()),
            NoiseSource::Independent(blocks) => blocks[group].clone(),
        };
        let total = unscaled * self.variance_factor;
        // Symmetric to the last bit, as the identification asks.
        (&total + total.transpose()) * 0.5
    }
}

fn dense(matrix: faer::MatRef<'_, f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
}
