//! Kinds of results.

use std::fmt;

use trueaxis_kinematics::{ARCSEC, Component, LocationComponent, MICROMETRE};

/// What a result is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// A component error, of any axis.
    Component(Component),
    /// The place of a rotary axis.
    Offset,
    /// Squareness, or the tilt of a rotary axis.
    Tilt,
    /// A coordinate of a station.
    Station,
    /// A dead path.
    DeadPath,
}

impl Kind {
    /// That of a location error.
    pub fn of_location(component: LocationComponent) -> Self {
        if component.is_angular() {
            Self::Tilt
        } else {
            Self::Offset
        }
    }

    /// Whether it is an angle.
    pub fn is_angular(self) -> bool {
        match self {
            Self::Component(component) => component.is_angular(),
            other => other == Self::Tilt,
        }
    }

    /// Whether it is an error of the machine, not of the set-up.
    pub fn is_of_machine(self) -> bool {
        !matches!(self, Self::Station | Self::DeadPath)
    }

    /// µm or arcsec with its size in mm or rad.
    pub fn unit(self) -> (&'static str, f64) {
        if self.is_angular() {
            ("″", ARCSEC)
        } else {
            ("µm", MICROMETRE)
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Component(component) => f.pad(&component.name("·")),
            Self::Offset => f.pad("offset"),
            Self::Tilt => f.pad("tilt"),
            Self::Station => f.pad("station"),
            Self::DeadPath => f.pad("dead path"),
        }
    }
}
