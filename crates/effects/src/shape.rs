//! The shape of an effect, the parameter that is not linear, and how files hold it.
//!
//! | shape | name | unit | may be |
//! | --- | --- | --- | --- |
//! | [`Shape::Instant`] | `time` | s | finite |
//! | [`Shape::TimeConstant`], [`Shape::SettlingTime`] | `time_constant` | s | positive |
//! | [`Shape::Lag`] | `time_constant` | s | zero or more |
//! | [`Shape::Period`] | `period` | mm, or deg for a rotary axis | positive |
//! | [`Shape::Waves`] | `waves` | 1 | 1, 2, 3, ... |

use crate::error::Problem;
use crate::{Effect, Parameter, Scene, Subject};

/// The parameter of an effect that is not linear.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// None.
    Fixed,
    /// An instant, s: the effect is there after it.
    Instant,
    /// A time constant over the campaign, s.
    TimeConstant,
    /// A time constant over the occupation of a station, s.
    SettlingTime,
    /// The time constant with which a part follows a temperature, s; 0 if it does so at once.
    Lag,
    /// A period along the axis, mm or rad.
    Period,
    /// A whole number of waves per turn, from this one on; fewer are those of another effect.
    Waves(u32),
}

const DEGREES: &str = "deg";

/// The parameter that stands for the shape in files, if there is one.
///
/// A period of a rotary axis is in degrees there, but in radians in [`Effect::form`] and
/// [`crate::ResolvedEffect`].
pub fn shape_parameter(effect: &Effect, scene: &Scene, subject: &Subject) -> Option<Parameter> {
    let unit = match effect.shape {
        Shape::Fixed => return None,
        Shape::Instant | Shape::TimeConstant | Shape::SettlingTime | Shape::Lag => "s",
        Shape::Period => scene.unit(subject, "mm", DEGREES),
        Shape::Waves(_) => "1",
    };
    effect.shape.name().map(|name| Parameter::new(name, unit))
}

impl Shape {
    /// Whether it is a time that passes until an effect has its size.
    pub fn is_duration(self) -> bool {
        self.name() == Some("time_constant")
    }

    /// The name of the parameter that stands for it.
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Self::Fixed => None,
            Self::Instant => Some("time"),
            Self::TimeConstant | Self::SettlingTime | Self::Lag => Some("time_constant"),
            Self::Period => Some("period"),
            Self::Waves(_) => Some("waves"),
        }
    }

    /// Refuses a finite value that it cannot have.
    pub(crate) fn check(self, value: f64) -> Result<(), Problem> {
        let expected = match self {
            Self::TimeConstant | Self::SettlingTime | Self::Period if value <= 0.0 => {
                "more than zero"
            }
            Self::Lag if value < 0.0 => "zero or more",
            Self::Waves(_) if value < 1.0 || value.fract() != 0.0 => "a whole number from 1",
            _ => return Ok(()),
        };
        Err(Problem::Value { value, expected })
    }
}

/// From the unit of the file to that of [`Effect::form`]: degrees become radians.
pub(crate) fn from_file(parameter: &Parameter, value: f64) -> f64 {
    match parameter.unit {
        DEGREES => value.to_radians(),
        _ => value,
    }
}

/// From the unit of [`Effect::form`] to that of the file.
pub(crate) fn to_file(parameter: &Parameter, value: f64) -> f64 {
    match parameter.unit {
        DEGREES => value.to_degrees(),
        _ => value,
    }
}
