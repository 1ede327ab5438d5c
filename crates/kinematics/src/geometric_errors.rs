//! Where a machine's errors come from.

use crate::{LocationError, MotionError};

/// The geometric errors of all axes of a machine, by index of the axis.
pub trait GeometricErrors {
    /// Location errors of the axis.
    fn location(&self, axis: usize) -> LocationError;

    /// Component errors of the axis at a position (mm or rad).
    fn motion(&self, axis: usize, position: f64) -> MotionError;
}

/// A machine without errors.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ideal;

impl GeometricErrors for Ideal {
    fn location(&self, _axis: usize) -> LocationError {
        LocationError::default()
    }

    fn motion(&self, _axis: usize, _position: f64) -> MotionError {
        MotionError::default()
    }
}
