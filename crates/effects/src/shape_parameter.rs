//! The shape of an effect as a parameter of a file: its name, its unit, what it may be.
//!
//! | shape | name | unit | may be |
//! | --- | --- | --- | --- |
//! | [`Shape::Instant`] | `time` | s | finite |
//! | [`Shape::TimeConstant`] | `time_constant` | s | positive |
//! | [`Shape::Period`] | `period` | mm, or deg for a rotary axis | positive |
//! | [`Shape::Waves`] | `waves` | 1 | 1, 2, 3, ... |

use trueaxis_kinematics::AxisKind;

use crate::{Effect, Error, Parameter, Scene, Shape, Subject};

const DEGREES: &str = "deg";

/// The parameter that stands for the shape in files, if there is one.
///
/// A period of a rotary axis is in degrees there, but in radians in [`Effect::form`] and
/// [`crate::ResolvedEffect`].
pub fn shape_parameter(effect: &dyn Effect, scene: &Scene, subject: &Subject) -> Option<Parameter> {
    let axis = subject.axis.and_then(|axis| scene.machine.axes().get(axis));
    let unit = match effect.shape() {
        Shape::Fixed => return None,
        Shape::Instant | Shape::TimeConstant => "s",
        Shape::Period => match axis.map(|axis| axis.kind()) {
            Some(AxisKind::Rotary) => DEGREES,
            Some(AxisKind::Linear) | None => "mm",
        },
        Shape::Waves => "1",
    };
    shape_name(effect.shape()).map(|name| Parameter::new(name, unit))
}

/// The name of the parameter that stands for a shape.
pub(crate) fn shape_name(shape: Shape) -> Option<&'static str> {
    match shape {
        Shape::Fixed => None,
        Shape::Instant => Some("time"),
        Shape::TimeConstant => Some("time_constant"),
        Shape::Period => Some("period"),
        Shape::Waves => Some("waves"),
    }
}

/// Refuses a finite value that the shape cannot have; `field` is its path.
pub(crate) fn check_shape(field: &str, shape: Shape, value: f64) -> Result<(), Error> {
    let (good, expected) = match shape {
        Shape::Fixed | Shape::Instant => (true, ""),
        Shape::TimeConstant | Shape::Period => (value > 0.0, "more than zero"),
        Shape::Waves => (
            value >= 1.0 && value.fract() == 0.0,
            "a whole number from 1",
        ),
    };
    if good {
        return Ok(());
    }
    Err(Error::Value {
        field: field.to_owned(),
        value,
        expected,
    })
}

/// From the unit of the file to that of [`Effect::form`]: degrees become radians.
pub(crate) fn from_file(parameter: &Parameter, value: f64) -> f64 {
    if parameter.unit == DEGREES {
        value.to_radians()
    } else {
        value
    }
}

/// From the unit of [`Effect::form`] to that of the file.
pub(crate) fn to_file(parameter: &Parameter, value: f64) -> f64 {
    if parameter.unit == DEGREES {
        value.to_degrees()
    } else {
        value
    }
}
