//! How to calibrate.

use nalgebra::Point3;
use trueaxis_identify::SixRows;

/// Settings of [`crate::calibrate`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// How six component errors follow from the measurement.
    pub method: Method,
    /// Whether the two sides of approach get curves of their own.
    pub by_direction: bool,
    /// The point of the stage whose translation is δ.
    pub reference_point: ReferencePoint,
    /// Whether the covariance of all results is wanted ([`crate::OutputCovariance`]).
    pub covariance: bool,
    /// Whether gross errors are removed and interrupted turns split; otherwise all lengths are
    /// adjusted as they are.
    pub robust: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            method: Method::default(),
            by_direction: false,
            reference_point: ReferencePoint::default(),
            covariance: false,
            robust: true,
        }
    }
}

/// How six component errors follow from the lengths or points of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The lengths of all steps in one adjustment with rigid stages: the pose of each step is an unknown
    /// of it. Measured points are identified as with [`Method::Nine`].
    #[default]
    Joint,
    /// Points first, each free of the others; then all nine equations (three for each target), weighted with
    /// the covariance of the points. The paper's path.
    Nine,
    /// Points first, then six of nine equations without weights; [`SixRows::PAPER`] is the paper's choice.
    Six(SixRows),
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
