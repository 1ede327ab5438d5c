//! Where the axes were measured, and the machine with one axis approached from one side.

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::Direction;
use trueaxis_kinematics::{AxisKind, GeometricErrors, LocationError, MotionError};

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

    /// The standard uncertainty of the lost motion of an axis: of the mean, over these positions, of its own deviation from above less
    /// that from below (of a linear axis at a point of the tool at home, with the lever of its angles), mm or rad. NaN if the calibration
    /// has no uncertainties or the axis was not measured.
    pub fn u_of_lost_motion(&self, axis: usize, positions: &[f64], at_mm: Point3<f64>) -> f64 {
        let Some(own) = self.axis(axis).filter(|_| self.has_uncertainties) else {
            return f64::NAN;
        };
        let geometry = &self.machine.axes()[axis];
        let direction = geometry.direction().into_inner();
        let (along, about) = match geometry.kind() {
            AxisKind::Linear => {
                let lever = at_mm - geometry.reference_mm();
                (direction, lever.cross(&direction))
            }
            AxisKind::Rotary => (Vector3::zeros(), direction),
        };
        let components: Vec<f64> = along.iter().chain(&about).copied().collect();
        let mut lost = Vec::new();
        for &position in positions {
            for (side, sign) in [(Direction::Backward, 1.0), (Direction::Forward, -1.0)] {
                for (node, weight) in own.curve.at_from(position, side).weights {
                    let share = sign * weight / positions.len() as f64;
                    let components = components.iter().enumerate();
                    let counts = components.filter(|(_, c)| **c != 0.0);
                    lost.extend(counts.map(|(k, c)| (own.first + 6 * node + k, share * c)));
                }
            }
        }
        self.factors.u(&lost)
    }

    /// The places of [`CalibratedMachine::volume`]: `points` nodes (two at least) along each linear axis, the others
    /// spread over their steps.
    pub fn places(&self, points: usize, tool_home_mm: Point3<f64>) -> Places {
        Places::new(self, points.max(2), tool_home_mm)
    }
}
