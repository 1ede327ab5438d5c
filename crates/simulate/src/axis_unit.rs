//! Axis positions between files (mm, deg) and kinematics (mm, rad).

use trueaxis_kinematics::AxisKind;

/// Position in mm or rad of a position in mm or deg. Zero loses its sign: -0 and 0 are one place.
pub(crate) fn from_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position + 0.0,
        AxisKind::Rotary => position.to_radians() + 0.0,
    }
}

/// Position in mm or deg of a position in mm or rad.
pub(crate) fn to_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position,
        AxisKind::Rotary => position.to_degrees(),
    }
}
