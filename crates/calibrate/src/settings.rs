//! How to calibrate.

use nalgebra::Point3;
use trueaxis_poses::{MOST_REMOVED, Method};

/// Settings of [`crate::calibrate()`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How six component errors follow from the measurement.
    pub method: Method,
    /// Whether the two sides of approach get curves of their own.
    pub by_direction: bool,
    /// The point of the stage whose translation is δ.
    pub reference_point: ReferencePoint,
    /// Whether the covariance of all results is wanted as one matrix ([`trueaxis_predict::OutputCovariance`]); in factors it
    /// is always there ([`trueaxis_predict::FactoredCovariance`]).
    pub covariance: bool,
    /// Whether gross errors are removed and interrupted occupations split; otherwise all lengths are
    /// adjusted as they are.
    pub robust: bool,
    /// Share of the lengths that may be removed as gross errors.
    pub most_removed: f64,
    /// As in [`trueaxis_poses::Settings`].
    pub asks_why: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            by_direction: false,
            reference_point: ReferencePoint::default(),
            covariance: false,
            robust: true,
            most_removed: MOST_REMOVED,
            asks_why: false,
        }
    }
}

impl Settings {
    /// Those of the poses.
    pub(crate) fn of_poses(&self) -> trueaxis_poses::Settings {
        trueaxis_poses::Settings {
            method: self.method,
            by_direction: self.by_direction,
            robust: self.robust,
            most_removed: self.most_removed,
            asks_why: self.asks_why,
        }
    }
}

/// The point of the stage whose translation is δ.
///
/// A rotary axis takes only its height along the axis: its reference point stays on the axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ReferencePoint {
    /// The origin of the stage frame (the paper): the reference frame's origin for a linear axis,
    /// `position_mm` for a rotary one.
    #[default]
    Origin,
    /// The centroid of the targets that the axis moves: the least noise.
    Centroid,
    /// A point in the reference frame at home, mm.
    At(Point3<f64>),
}
