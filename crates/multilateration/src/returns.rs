//! How a machine comes back to the points of a group.

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::Lanes;

use crate::Network;
use crate::lane_vectors::{LaneVector, cross, dot, minus};

/// The points of a group return displaced, and turned about an axis by a normal angle common to a visit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Return {
    /// Variance of a coordinate over that of the network's [`Noise::repeatability_mm`](crate::Noise).
    pub variance_ratio: f64,
    /// A point on the axis, mm.
    pub point_mm: Point3<f64>,
    /// Unit vector along the axis, times the standard deviation of the angle over the network's repeatability, rad/mm; zero
    /// where nothing turns.
    pub rad_per_mm: Vector3<f64>,
}

impl Return {
    /// Increase of a length from a station to a point by one standard deviation of the angle, in units of
    /// the repeatability.
    pub fn lever_mm(&self, station_mm: Point3<f64>, point_mm: Point3<f64>) -> f64 {
        let moved = self.rad_per_mm.cross(&(point_mm - self.point_mm));
        (point_mm - station_mm).normalize().dot(&moved)
    }
}

/// How the groups of a batch return.
#[derive(Debug)]
pub(crate) struct LaneReturn {
    pub(crate) variance_ratio: Lanes,
    point_mm: LaneVector,
    rad_per_mm: LaneVector,
}

impl LaneReturn {
    /// The returns of some groups; `None` where all groups of the network return alike.
    pub(crate) fn of(network: &Network, groups: &std::ops::Range<usize>) -> Option<Self> {
        let all = &network.returns.as_deref()?[groups.clone()];
        let lanes = |part: &dyn Fn(&Return) -> f64| {
            Lanes::from_fn(|lane| part(&all[lane.min(all.len() - 1)]))
        };
        Some(Self {
            variance_ratio: lanes(&|group| group.variance_ratio),
            point_mm: [0, 1, 2].map(|i| lanes(&|group| group.point_mm[i])),
            rad_per_mm: [0, 1, 2].map(|i| lanes(&|group| group.rad_per_mm[i])),
        })
    }

    /// Increase of a length, in units of the repeatability, by one standard deviation of the angle; `unit` is along
    /// the beam to `point`.
    #[inline(always)]
    pub(crate) fn lever(&self, unit: LaneVector, point: LaneVector) -> Lanes {
        dot(unit, cross(self.rad_per_mm, minus(point, self.point_mm)))
    }
}
