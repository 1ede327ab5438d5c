//! How to calibrate.

use nalgebra::Point3;

/// Settings of [`crate::calibrate()`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// How to find the poses. If both sides of approach have their own poses, they have their own error curves.
    pub poses: trueaxis_poses::Settings,
    /// The point of the stage whose translation is δ.
    pub reference_point: ReferencePoint,
    /// Whether to make the covariance of all results as one matrix ([`trueaxis_predict::OutputCovariance`]), too; its
    /// factors are always made ([`trueaxis_predict::FactoredCovariance`]).
    pub covariance: bool,
}

/// The point of the stage whose translation is δ.
///
/// A rotary axis uses only the height of the point along the axis: its reference point stays on the axis.
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
