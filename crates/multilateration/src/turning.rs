//! The axis about which a machine also turns when it returns to the points of a group.

use nalgebra::{Point3, Vector3};
use trueaxis_leastsquares::{LANES, Lanes};

use crate::Network;
use crate::lane_vectors::{LaneVector, cross, dot, minus};

/// The points of a group also return turned about an axis, by a normal angle common to a visit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turning {
    /// A point on the axis, mm.
    pub point_mm: Point3<f64>,
    /// Unit vector along the axis, times the standard deviation of the angle over that of a coordinate
    /// ([`Noise::repeatability_mm`](crate::Noise)), rad/mm.
    pub rad_per_mm: Vector3<f64>,
}

/// The axes of the groups of a batch.
#[derive(Debug)]
pub(crate) struct LaneTurning {
    point_mm: LaneVector,
    rad_per_mm: LaneVector,
}

impl LaneTurning {
    /// The axes of some groups; `None` where no group of the network has one.
    pub(crate) fn of(network: &Network, groups: &std::ops::Range<usize>) -> Option<Self> {
        let all = &network.turning.as_deref()?[groups.clone()];
        let lanes = |part: &dyn Fn(&Turning) -> f64| {
            let of_lane = |lane: usize| all[lane.min(all.len() - 1)].as_ref().map_or(0.0, part);
            Lanes(std::array::from_fn::<f64, LANES, _>(of_lane))
        };
        Some(Self {
            point_mm: [0, 1, 2].map(|i| lanes(&|turning| turning.point_mm[i])),
            rad_per_mm: [0, 1, 2].map(|i| lanes(&|turning| turning.rad_per_mm[i])),
        })
    }

    /// Increase of a length, in units of the repeatability, by one standard deviation of the angle; `unit` is along
    /// the beam to `point`.
    #[inline(always)]
    pub(crate) fn lever(&self, unit: LaneVector, point: LaneVector) -> Lanes {
        dot(unit, cross(self.rad_per_mm, minus(point, self.point_mm)))
    }
}
