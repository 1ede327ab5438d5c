//! Location errors: where the average line or axis lies.

use nalgebra::Vector3;

/// How far the average line of a linear axis, or the average axis of rotation, is from nominal.
///
/// `tilt_rad` is the rotation vector that turns the nominal direction onto the average one: its
/// parts are `A0? B0? C0?` (right-hand rule), so a tilt about z by `C0Y` gives Y the direction
/// `(-C0Y, 1, 0)`. `offset_mm` (`X0? Y0? Z0?`) applies to rotary axes only: its part across the
/// axis shifts the line, its part along the axis shifts what the axis carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LocationError {
    /// Shift of the axis of rotation, mm.
    pub offset_mm: Vector3<f64>,
    /// Rotation vector from the nominal to the average direction, rad.
    pub tilt_rad: Vector3<f64>,
}

/// One location error by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LocationComponent {
    /// Shift along x, y or z (0, 1, 2).
    Offset(usize),
    /// Tilt about x, y or z (0, 1, 2).
    Tilt(usize),
}

impl LocationComponent {
    /// ISO 230-1 name for the axis `axis`, such as `C0Y` or `X0C`.
    pub fn name(self, axis: &str) -> String {
        let letter = match self {
            Self::Offset(i) => ['X', 'Y', 'Z'][i],
            Self::Tilt(i) => ['A', 'B', 'C'][i],
        };
        format!("{letter}0{axis}")
    }

    /// Its value in `location`: mm for a shift, rad for a tilt.
    pub fn of(self, location: &LocationError) -> f64 {
        match self {
            Self::Offset(i) => location.offset_mm[i],
            Self::Tilt(i) => location.tilt_rad[i],
        }
    }

    /// The same, to be changed.
    pub fn of_mut(self, location: &mut LocationError) -> &mut f64 {
        match self {
            Self::Offset(i) => &mut location.offset_mm[i],
            Self::Tilt(i) => &mut location.tilt_rad[i],
        }
    }

    /// Whether it is an angle.
    pub fn is_angular(self) -> bool {
        matches!(self, Self::Tilt(_))
    }
}
