//! Points with their covariance, from lengths or from coordinates.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, Matrix2, Point3};
use trueaxis_campaign::Direction;
use trueaxis_multilateration::Screened;

use crate::point_noise::{NoiseSource, PointNoise};

/// All measured points in the datum: best fit to their nominal positions.
pub(crate) struct Measured {
    pub(crate) groups: Vec<MeasuredGroup>,
    pub(crate) points_mm: Vec<Point3<f64>>,
    pub(crate) noise: PointNoise<'static>,
    /// What the groups' covariances in a points campaign would be if the machine returned exactly,
    /// mm²; nothing where lengths were measured, of whose network that follows.
    pub(crate) without_return: Vec<DMatrix<f64>>,
    /// How well the two variance factors of the noise (the instrument's, the machine's return) are
    /// known: their covariance relative to their values. Zero if the declared noise is taken for
    /// the truth.
    pub(crate) relative_covariance: Matrix2<f64>,
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

impl Measured {
    /// The instrument's own part of the noise, with the same factor on all variances; `screened`
    /// is the adjustment of the lengths, if lengths were measured.
    pub(crate) fn instrument_noise<'a>(&self, screened: Option<&'a Screened>) -> PointNoise<'a> {
        let source = match screened {
            Some(Screened {
                network, solution, ..
            }) => NoiseSource::Lengths(Box::new(solution.length_noise(network))),
            None => NoiseSource::Independent(self.without_return.clone()),
        };
        PointNoise {
            source,
            variance_factor: self.noise.variance_factor,
            batches: Arc::clone(&self.noise.batches),
        }
    }
}
