//! All component and location errors, for controls that have a model of the machine of their own.

use nalgebra::{Point3, Vector3, Vector6};
use trueaxis_kinematics::{
    Axis, AxisKind, Branch, GeometricErrors, LocationComponent, LocationError, Machine, MotionError,
};

use crate::Error;
use crate::correct::added;
use crate::export::Request;
use crate::export::line::{interpolate, positions};

/// What rounding leaves of a location error that is none, mm or rad.
const ROUNDING: f64 = 1e-12;

/// Names of axes in the standard.
const NAMES: [&str; 6] = ["X", "Y", "Z", "A", "B", "C"];

/// The errors as the control has them: δ of linear axes at the origin of the reference frame, of rotary ones at the point that the
/// machine gives them by, linear between points.
pub(crate) struct Components {
    machine: Machine,
    at: Point3<f64>,
    pub(crate) axes: Vec<AxisComponents>,
}

/// The errors of one axis.
#[derive(Debug, Clone)]
pub(crate) struct AxisComponents {
    pub(crate) axis: usize,
    /// mm or rad.
    pub(crate) positions: Vec<f64>,
    /// mm and rad.
    pub(crate) errors: Vec<MotionError>,
    pub(crate) location: LocationError,
    /// ISO 230-1 names and values of the location errors that are not zero, mm or rad.
    pub(crate) locations: Vec<(String, f64)>,
}

impl Components {
    pub(crate) fn new(request: &Request<'_>) -> Result<Self, Error> {
        let calibrated = request.machine;
        let machine = calibrated.machine();
        let mut axes = machine.axes().iter();
        if let Some(axis) = axes.find(|axis| !NAMES.contains(&axis.name())) {
            let lacks = format!("this machine has an axis {}", axis.name());
            return Err(request.unsuitable("axes named X, Y, Z, A, B, C", lacks));
        }
        // A shift that is there at home is the zero of the control, unless rotary axes show it.
        let mut axes = machine.axes().iter();
        let all_linear = axes.all(|axis| axis.kind() == AxisKind::Linear);
        let at_origin = machine.with_axes(|_, axis| {
            let point_mm = match axis.kind() {
                AxisKind::Linear => Point3::origin(),
                AxisKind::Rotary => axis.point_mm(),
            };
            axis.with_reference(point_mm)
        });
        let of_axis = |axis: usize| {
            let geometry = &machine.axes()[axis];
            let location = calibrated.location(axis);
            // From the reference point of δ to where the control has it.
            let way = match geometry.kind() {
                AxisKind::Linear => -geometry.reference_mm().coords,
                AxisKind::Rotary => along_to_point(geometry, &location),
            };
            let error = |position: f64| {
                let error = calibrated.motion(axis, position);
                let turned = error.isometry().rotation * way;
                MotionError::new(error.translation_mm + turned - way, error.rotation_rad)
            };
            let home = match all_linear {
                true => error(0.0).translation_mm,
                false => Vector3::zeros(),
            };
            let positions = positions(request, axis)?;
            let errors = positions.iter().map(|&position| {
                let error = error(position);
                MotionError::new(error.translation_mm - home, error.rotation_rad)
            });
            let location = at_point(geometry, &location);
            // Of an oblique axis all three: a reader adds nothing.
            let tilts = (0..3).map(LocationComponent::Tilt);
            let components = (0..3).map(LocationComponent::Offset).chain(tilts);
            let named = components.map(|c| (c.name(geometry.name()), c.of(&location)));
            Ok(AxisComponents {
                axis,
                errors: errors.collect(),
                positions,
                location,
                locations: named.filter(|(_, value)| value.abs() > ROUNDING).collect(),
            })
        };
        let axes = request.axes()?.into_iter().map(of_axis);
        Ok(Self {
            axes: axes.collect::<Result<_, Error>>()?,
            machine: at_origin,
            at: request.at,
        })
    }

    /// What the control adds: the linear axes bring the tool point to its place.
    pub(crate) fn added(&self, commanded: &[f64]) -> Result<Vec<f64>, Error> {
        added(&self.machine, self, commanded, self.at)
    }

    /// The convention, for the notes.
    pub(crate) fn notes(&self, request: &Request<'_>) -> Vec<String> {
        let [tool, workpiece] = [Branch::Tool, Branch::Workpiece].map(|branch| {
            let axes = self.machine.branch(branch).iter();
            axes.map(|&axis| request.name(axis)).collect::<Vec<_>>()
        });
        let listed = |names: &[&str]| match names {
            [] => "none".to_owned(),
            names => names.join(" "),
        };
        let from_the_workpiece = workpiece.iter().rev().chain(&tool).copied();
        let mut notes = vec![
            "mm and rad, arguments of rotary axes in degrees; ISO 230-1, actual minus nominal, right-hand rule; linear axes at \
             the origin of the reference frame, rotary ones at the point of the nominal axis that the machine gives; mean of both sides of approach"
                .to_owned(),
            format!(
                "from the bed: tool {}; workpiece {}: chain {}, workpiece_axes {}",
                listed(&tool),
                listed(&workpiece),
                from_the_workpiece.collect::<String>(),
                workpiece.len()
            ),
            "the sign that the control expects is not documented in public: run one line with a laser after activation; if its error \
             doubles, negate"
                .to_owned(),
        ];
        let mut axes = self.machine.axes().iter();
        if axes.any(|axis| axis.kind() == AxisKind::Rotary) {
            let turns = "alternative_model 1: a rotary axis is meant to turn about where it is, and the control's own model turns it about \
                         where it should be";
            notes.push(turns.to_owned());
        }
        notes.push(request.origin());
        notes
    }
}

/// The way along the average axis from the reference point of δ to the point that a rotary axis is given by, mm.
fn along_to_point(axis: &Axis, location: &LocationError) -> Vector3<f64> {
    let average = axis.average_direction(location).into_inner();
    let height_mm = (axis.point_mm() - axis.reference_mm()).dot(&axis.direction());
    average * (height_mm / average.dot(&axis.direction()))
}

/// The same location error with its shift at that point.
fn at_point(axis: &Axis, location: &LocationError) -> LocationError {
    let apart = axis.reference_mm() - axis.point_mm();
    match axis.kind() {
        AxisKind::Linear => *location,
        AxisKind::Rotary => LocationError {
            offset_mm: location.offset_mm + apart + along_to_point(axis, location),
            ..*location
        },
    }
}

impl GeometricErrors for Components {
    fn location(&self, axis: usize) -> LocationError {
        let own = self.axes.iter().find(|own| own.axis == axis);
        own.map_or_else(LocationError::default, |own| own.location)
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let Some(own) = self.axes.iter().find(|own| own.axis == axis) else {
            return MotionError::default();
        };
        let of = |c: usize| interpolate(&own.positions, |k| own.errors[k].to_vector()[c], position);
        MotionError::from_vector(&Vector6::from_fn(|c, _| of(c)))
    }
}
