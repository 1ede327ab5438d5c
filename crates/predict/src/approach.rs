//! Where the axes were measured, and the machine with one axis approached from one side.

use nalgebra::Point3;
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{GeometricErrors, LocationError, MotionError};

use crate::calibrated_machine::CalibratedMachine;
use crate::volume::places::Places;

/// A calibrated machine whose axis `axis` comes to its positions from one side; all other axes are at the mean of
/// their sides.
#[derive(Debug, Clone, Copy)]
pub struct Approach<'a> {
    /// The machine.
    pub machine: &'a CalibratedMachine,
    /// Index of the axis.
    pub axis: usize,
    /// The side.
    pub direction: Direction,
}

impl GeometricErrors for Approach<'_> {
    fn location(&self, axis: usize) -> LocationError {
        self.machine.location(axis)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        match self.machine.axis(axis) {
            Some(own) if axis == self.axis => {
                own.error(&own.curve.at_from(position, self.direction))
            }
            _ => self.machine.motion(axis, position),
        }
    }
}

impl CalibratedMachine {
    /// The positions at which an axis was measured, rising, mm or rad; none if it was not.
    pub fn steps(&self, axis: usize) -> Vec<f64> {
        self.axis(axis)
            .map_or_else(Vec::new, |axis| axis.curve.steps())
    }

    /// Whether the sides of approach of an axis have curves of their own.
    pub fn keeps_sides_apart(&self, axis: usize) -> bool {
        self.axis(axis)
            .is_some_and(|axis| axis.curve.keeps_sides_apart())
    }

    /// The places of [`CalibratedMachine::volume`]: `points` nodes (two at least) along each linear axis, the others
    /// spread over their steps.
    pub fn places(&self, points: usize, tool_home_mm: Point3<f64>) -> Places {
        Places::new(self, points.max(2), tool_home_mm)
    }
}
