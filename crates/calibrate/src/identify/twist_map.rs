//! Twists in another frame.

use nalgebra::{Matrix3, Matrix6};

/// The map of twists that turns both parts and moves the pivot: translations of the new one by rotations.
pub(crate) fn twist_map(turn: &Matrix3<f64>, by_rotation: &Matrix3<f64>) -> Matrix6<f64> {
    let mut map = Matrix6::zeros();
    map.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
    map.fixed_view_mut::<3, 3>(3, 3).copy_from(turn);
    map.fixed_view_mut::<3, 3>(0, 3).copy_from(by_rotation);
    map
}
