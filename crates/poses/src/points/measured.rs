//! Measured points with their errors: the input of the nine and the six equations.
//!
//! ```text
//! dp_i = ξ_i - Z_i s     cov(ξ_i) = D_i, independent between steps     cov(s) = Σ
//! ```

use nalgebra::{DMatrix, Matrix2, Matrix3, Point3, Vector3};
use trueaxis_campaign::Direction;

use crate::points::equations::Source;

/// All measured points in the datum, the best fit to their nominal positions.
pub(crate) struct MeasuredPoints {
    pub(crate) groups: Vec<PointGroup>,
    pub(crate) noise: PointNoise,
    /// The instrument's own part of the noise.
    pub(crate) instrument: PointNoise,
    /// As [`crate::Poses::relative_covariance`].
    pub(crate) relative_covariance: Matrix2<f64>,
    /// The readings that each group's points are means of; none where lengths were measured.
    pub(crate) readings: Vec<Vec<GroupReading>>,
    /// Variance of a coordinate by the machine's repeatability, mm².
    pub(crate) repeatability_variance_mm2: f64,
}

/// The targets of one step (and side of approach, if the sides are kept apart).
#[derive(Debug, Clone)]
pub(crate) struct PointGroup {
    pub(crate) step: usize,
    pub(crate) direction: Option<Direction>,
    pub(crate) targets: Vec<usize>,
    pub(crate) points_mm: Vec<Point3<f64>>,
}

/// One reading of a point.
#[derive(Debug, Clone)]
pub(crate) struct GroupReading {
    /// The reading of the campaign, and its visit.
    pub(crate) reading: usize,
    pub(crate) visit: usize,
    /// The index of its target in the group.
    pub(crate) place: usize,
    /// Covariance of its own noise in the datum, mm².
    pub(crate) own_mm2: Matrix3<f64>,
    /// Its share of the weight of the point.
    pub(crate) share: f64,
    /// Difference from the point, which is the mean, in the datum, mm.
    pub(crate) off_mean_mm: Vector3<f64>,
}

impl MeasuredPoints {
    /// Covariance of a reading with the point at `place` of its group, mm²; `readings` are all of the group.
    pub(crate) fn covariance_with_mean(
        &self,
        reading: &GroupReading,
        place: usize,
        readings: &[GroupReading],
    ) -> Matrix3<f64> {
        let own = match reading.place == place {
            true => reading.own_mm2 * reading.share,
            false => Matrix3::zeros(),
        };
        let of_visit = readings
            .iter()
            .filter(|other| other.place == place && other.visit == reading.visit);
        let common =
            self.repeatability_variance_mm2 * of_visit.map(|other| other.share).sum::<f64>();
        own + Matrix3::from_diagonal_element(common)
    }
}

/// Covariance of the points, mm².
#[derive(Debug, Clone, Default)]
pub(crate) struct PointNoise {
    /// `D` of each group, three rows for each point.
    pub(crate) own: Vec<DMatrix<f64>>,
    /// `Z` of each group.
    pub(crate) coupling: Vec<DMatrix<f64>>,
    /// `Σ`: first the stations (x y z and dead path of each).
    pub(crate) shared: DMatrix<f64>,
    /// As [`crate::PoseNoise::declared`] and [`crate::PoseNoise::stations`].
    pub(crate) declared: DMatrix<f64>,
    pub(crate) stations: DMatrix<f64>,
}

impl PointNoise {
    /// `D` and `Z` of the points that a pose comes from.
    pub(crate) fn of(&self, Source { group, places, .. }: &Source) -> (DMatrix<f64>, DMatrix<f64>) {
        let rows: Vec<usize> = places.iter().flat_map(|p| 3 * p..3 * p + 3).collect();
        let own = self.own[*group].select_rows(&rows).select_columns(&rows);
        (own, self.coupling[*group].select_rows(&rows))
    }

    /// The largest variance of a coordinate at the first step, mm².
    pub(crate) fn largest_variance_mm2(&self) -> f64 {
        let first = self.own.first().zip(self.coupling.first());
        first.map_or(0.0, |(own, z)| {
            (own + z * &self.shared * z.transpose()).diagonal().max()
        })
    }
}
