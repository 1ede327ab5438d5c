//! From points to poses.

mod coordinates;
pub(crate) mod equations;
mod measured;
pub(crate) mod noise_shown;
mod repeats;
pub(crate) mod report;
mod residuals;
pub(crate) mod rigidity;
pub(crate) mod turned_runs;

pub(crate) use coordinates::points_from_coordinates;
pub(crate) use measured::{GroupReading, MeasuredPoints, PointGroup, PointNoise};
