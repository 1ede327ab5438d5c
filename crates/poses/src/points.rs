//! From points to poses.

mod anisotropy;
mod coordinates;
pub(crate) mod equations;
mod measured;
pub(crate) mod noise_shown;
mod repeats;
pub(crate) mod report;
mod residuals;
pub(crate) mod rigidity;
pub(crate) mod turned_runs;

pub(crate) use anisotropy::noise_of_coordinates;
pub(crate) use coordinates::points_from_coordinates;
pub(crate) use measured::{GroupReading, MeasuredPoints, PointGroup, PointNoise};

/// Standard deviation of a coordinate where none is declared, µm: it only makes weights equal.
const UNDECLARED_SIGMA_UM: f64 = 1.0;
