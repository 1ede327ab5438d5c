//! From points to poses.

mod coordinates;
pub(crate) mod equations;
mod measured;
pub(crate) mod report;
pub(crate) mod rigidity;

pub(crate) use coordinates::points_from_coordinates;
pub(crate) use measured::{MeasuredPoints, PointGroup, PointNoise};
