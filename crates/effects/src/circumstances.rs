//! When, where and how a reading was taken.

use nalgebra::{Isometry3, Point3, Rotation3, Vector3};
use trueaxis_kinematics::{AxisKind, Ideal, Machine};

use crate::TemperatureHistory;

/// The circumstances of one reading, as far as an effect may depend on them.
///
/// Lengths are mm, angles rad, times s; positions are in the reference frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circumstances<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Time on the clock of the campaign (`time_s` of its files), s; instants are given on it.
    pub time_s: f64,
    /// Time since the first reading of the campaign, s.
    pub elapsed_s: f64,
    /// Progress of time over the campaign, 0 to 1.
    pub progress: f64,
    /// Progress of time within the occupation of the station, 0 to 1.
    pub occupation_progress: f64,
    /// Time since the first reading of the occupation of the station, s.
    pub occupation_elapsed_s: f64,
    /// The station that reads; 0 without any.
    pub station: usize,
    /// The target that is read.
    pub target: usize,
    /// The outermost axis that moves the target; none on the bed, to which the machine does nothing.
    pub carrier: Option<usize>,
    /// The axis that moves between the readings; any for a target on the bed.
    pub axis: usize,
    /// Side of approach, +1 or -1; any for a target on the bed.
    pub direction: f64,
    /// Speed with sign of the axis at the reading, mm/s or rad/s; 0 where the machine stands still.
    pub speed_per_s: f64,
    /// Commanded positions of all axes, mm or rad.
    pub positions: &'a [f64],
    /// Where the target is.
    pub point_mm: Point3<f64>,
    /// Orientation of the stage against home, where it was measured; otherwise it follows from the commanded positions.
    pub stage: Option<Rotation3<f64>>,
    /// Centroid of the targets that sit on the same stage.
    pub centroid_mm: Point3<f64>,
    /// Distance from the station to the target.
    pub distance_mm: f64,
    /// The courses of the temperatures of the scene; those that are missing never change.
    pub temperatures: &'a [TemperatureHistory],
}

impl<'a> Circumstances<'a> {
    /// A reading at home, at the start, of a target in the origin on the stage of the first axis.
    pub fn new(machine: &'a Machine) -> Self {
        Self {
            machine,
            time_s: 0.0,
            elapsed_s: 0.0,
            progress: 0.0,
            occupation_progress: 0.0,
            occupation_elapsed_s: 0.0,
            station: 0,
            target: 0,
            carrier: Some(0),
            axis: 0,
            direction: 1.0,
            speed_per_s: 0.0,
            positions: &[],
            point_mm: Point3::origin(),
            stage: None,
            centroid_mm: Point3::origin(),
            distance_mm: 0.0,
            temperatures: &[],
        }
    }

    /// Orientation of the target's stage against home.
    pub fn ref_from_stage(&self) -> Rotation3<f64> {
        let commanded = || self.machine.motion(&Ideal, self.carrier, self.positions);
        self.stage
            .unwrap_or_else(|| commanded().rotation.to_rotation_matrix())
    }

    /// Whether an axis moves the target.
    pub fn is_carried_by(&self, axis: usize) -> bool {
        self.machine.chain(self.carrier).contains(&axis)
    }

    /// Commanded position of an axis, mm or rad; 0 of one that is not given.
    pub fn position(&self, axis: usize) -> f64 {
        self.positions.get(axis).copied().unwrap_or(0.0)
    }

    /// Where what carries an axis stands, from the commanded positions.
    pub fn ref_from_base(&self, axis: usize) -> Isometry3<f64> {
        let chain = self.machine.chain(axis);
        let before = &chain[..chain.len() - 1];
        self.machine.chain_motion(&Ideal, before, self.positions)
    }

    /// Displacement of the target when an axis makes a small additional motion: 1 mm along a linear axis,
    /// 1 rad about a rotary one (to first order). Zero if the axis does not move the target.
    pub(crate) fn unit_motion(&self, axis: usize) -> Vector3<f64> {
        if !self.is_carried_by(axis) {
            return Vector3::zeros();
        }
        let ref_from_base = self.ref_from_base(axis);
        let axis = &self.machine.axes()[axis];
        let direction = ref_from_base.rotation * axis.direction().into_inner();
        match axis.kind() {
            AxisKind::Linear => direction,
            AxisKind::Rotary => {
                let on_axis = ref_from_base * axis.reference_mm();
                direction.cross(&(self.point_mm - on_axis))
            }
        }
    }
}
