//! Where an axis is while the machine stands at given positions.

use nalgebra::{Point3, Vector3};
use trueaxis_kinematics::{AxisKind, Ideal};

use crate::Circumstances;

/// Displacement of the target when the axis makes a small additional motion: 1 mm along a linear axis,
/// 1 rad about a rotary one (to first order). Zero if the axis does not move the target.
pub(crate) fn unit_motion(axis: usize, at: &Circumstances<'_>) -> Vector3<f64> {
    if !at.is_carried_by(axis) {
        return Vector3::zeros();
    }
    let chain = at.machine.chain(axis);
    let before = &chain[..chain.len() - 1];
    let ref_from_base = at.machine.chain_motion(&Ideal, before, at.positions);
    let content = &at.machine.axes()[axis];
    let direction = ref_from_base.rotation * content.direction().into_inner();
    match content.kind() {
        AxisKind::Linear => direction,
        AxisKind::Rotary => {
            let on_axis: Point3<f64> = ref_from_base * content.reference_mm();
            direction.cross(&(at.point_mm - on_axis))
        }
    }
}
