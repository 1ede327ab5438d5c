//! Component and location errors with those of the tables that were active while the machine was measured.
//!
//! What is measured is what the old tables left, so that to first order the errors add up: at the positions of both.

use nalgebra::{Point3, Vector6};
use trueaxis_kinematics::{Axis, LocationError, Machine, MotionError};

use crate::Error;
use crate::export::components::{AxisComponents, Components};
use crate::export::line::interpolate;
use crate::export::named_errors::{AxisErrors, NamedErrors};
use crate::export::{Request, one_file, rising};

/// Positions this close are one, mm or rad.
const SAME: f64 = 1e-9;

/// What files of named errors get.
pub(crate) struct WithOld {
    pub(crate) axes: Vec<AxisComponents>,
    /// What stays as it is in the old one: no errors.
    pub(crate) of_the_tool: Vec<(String, f64)>,
}

/// The errors of `request`, with the old ones if there are any.
pub(crate) fn onto(
    request: &Request<'_>,
    components: &Components,
    format: &'static str,
    read: fn(&str, &str) -> Result<NamedErrors, Error>,
) -> Result<WithOld, Error> {
    match request.onto {
        [] => Ok(WithOld {
            axes: components.axes.clone(),
            of_the_tool: Vec::new(),
        }),
        [old] => {
            let machine = request.machine.machine();
            let read = read(&old.name, &old.text)?;
            let old = read.of_machine(machine)?;
            Ok(WithOld {
                axes: with_old(machine, &components.axes, &old),
                of_the_tool: read.of_the_tool,
            })
        }
        more => Err(one_file(format, more.len())),
    }
}

/// The new errors of each axis with the old ones; axes that only the old tables have stay as they are.
fn with_old(machine: &Machine, new: &[AxisComponents], old: &[AxisErrors]) -> Vec<AxisComponents> {
    let axes = 0..machine.axes().len();
    let of_axis = |axis: usize| {
        let new = new.iter().find(|new| new.axis == axis);
        let old = old.iter().find(|old| old.axis == axis);
        match (new, old) {
            (new, None) => new.cloned(),
            (new, Some(old)) => Some(sum(&machine.axes()[axis], new, old)),
        }
    };
    axes.filter_map(of_axis).collect()
}

fn sum(axis: &Axis, new: Option<&AxisComponents>, old: &AxisErrors) -> AxisComponents {
    let new_positions = new.map_or(&[][..], |new| new.positions.as_slice());
    let new_errors = new.map_or(&[][..], |new| new.errors.as_slice());
    let old_errors: Vec<MotionError> = old
        .errors
        .iter()
        .map(|error| at(error, old.centre_mm, axis.reference_mm()))
        .collect();
    let positions = new_positions.iter().chain(&old.positions);
    let positions = rising(positions.copied(), SAME);
    let error = |&position: &f64| {
        let part = |positions: &[f64], errors: &[MotionError], c: usize| match positions {
            [] => 0.0,
            _ => interpolate(positions, |k| errors[k].to_vector()[c], position),
        };
        MotionError::from_vector(&Vector6::from_fn(|c, _| {
            part(new_positions, new_errors, c) + part(&old.positions, &old_errors, c)
        }))
    };
    let errors = positions.iter().map(error).collect();
    let of_new = new.map_or(&[][..], |new| new.locations.as_slice());
    let names = axis.location_components().into_iter();
    let locations = names.filter_map(|component| {
        let name = component.name(axis.name());
        let new = of_new.iter().find(|(own, _)| *own == name);
        let old = old.locations.iter().find(|(own, _)| *own == component);
        let value = new.map_or(0.0, |(_, x)| *x) + old.map_or(0.0, |(_, x)| *x);
        (new.is_some() || old.is_some()).then_some((name, value))
    });
    AxisComponents {
        axis: old.axis,
        errors,
        locations: locations.collect(),
        // What the control makes of the old part is not asked here.
        location: new.map_or_else(LocationError::default, |new| new.location),
        positions,
    }
}

/// An error given for another point of the axis.
fn at(error: &MotionError, from: Option<Point3<f64>>, to: Point3<f64>) -> MotionError {
    let lever_mm = from.map_or_else(Default::default, |from| to - from);
    MotionError::new(error.displacement_mm(lever_mm), error.rotation_rad)
}
