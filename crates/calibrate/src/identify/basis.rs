//! Two directions across an axis.

use nalgebra::Vector3;
use trueaxis_kinematics::Axis;

/// A right-handed orthonormal basis along an axis: `across[0] × across[1] = along`.
///
/// For an axis along a reference direction these are the other two reference directions.
pub(crate) struct Basis {
    pub(crate) across: [Vector3<f64>; 2],
    pub(crate) along: Vector3<f64>,
}

impl Basis {
    pub(crate) fn of(axis: &Axis) -> Self {
        let along = axis.direction().into_inner();
        let first = Vector3::ith((axis.principal() + 1) % 3, 1.0);
        let first = (first - along * first.dot(&along)).normalize();
        Self {
            across: [first, along.cross(&first)],
            along,
        }
    }
}
