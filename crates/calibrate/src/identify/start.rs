//! The start of the identification: the average line or axis of rotation of each axis.
//!
//! The average line through the traces of all targets gives the direction of a linear axis, the common axis of their
//! circles that of a rotary one. Even for a machine that is degrees off nominal, the result is then only small errors
//! away. What traces of few points do not determine stays nominal.

use nalgebra::{Isometry3, Point3, Unit, Vector3};
use trueaxis_fitting::{axis_location, fit_common_axis, fit_line, squareness};
use trueaxis_kinematics::{Axis, AxisKind, Ideal, LocationError, MotionError};

use crate::identify::axis_data::{AxisData, RunData};
use crate::identify::context::Context;
use crate::identify::state::{AxisState, State};

/// The nominal machine with average directions and axes.
pub(crate) fn average_lines_and_axes(context: &Context<'_>) -> State {
    let axes = context
        .data
        .iter()
        .map(|axis| AxisState {
            location: axis
                .runs
                .first()
                .and_then(|run| location(context, axis, run))
                .unwrap_or_default(),
            curve: vec![MotionError::default(); axis.nodes.len()],
            placements: vec![Isometry3::identity(); axis.runs.len()],
        })
        .collect();
    State {
        ref_from_datum: Isometry3::identity(),
        axes,
    }
}

fn location(context: &Context<'_>, data: &AxisData, run: &RunData) -> Option<LocationError> {
    let axis = &context.machine.axes()[data.axis];
    let traces = traces(context, data, run);
    match axis.kind() {
        AxisKind::Linear => line_location(axis, &traces),
        AxisKind::Rotary => {
            let circles: Vec<&[Point3<f64>]> = traces.iter().map(Vec::as_slice).collect();
            let mut measured = fit_common_axis(&circles).ok()?.axis;
            // The machine defines the sense of rotation; only the line is needed here.
            if measured.direction.dot(&axis.direction()) <= 0.0 {
                measured.direction = -measured.direction;
            }
            axis_location(axis, &measured).ok()
        }
    }
}

fn line_location(axis: &Axis, traces: &[Vec<Point3<f64>>]) -> Option<LocationError> {
    let mut sum = Vector3::zeros();
    for trace in traces {
        let direction = fit_line(trace).ok()?.direction.into_inner();
        sum += direction * direction.dot(&axis.direction()).signum();
    }
    let average = Unit::try_new(sum, f64::MIN_POSITIVE)?;
    let tilt_rad = squareness(axis.direction(), average);
    Some(LocationError {
        offset_mm: Vector3::zeros(),
        tilt_rad,
    })
}

/// The points of each target in order of position, seen from the base of the axis.
fn traces(context: &Context<'_>, data: &AxisData, run: &RunData) -> Vec<Vec<Point3<f64>>> {
    let mut poses: Vec<_> = data
        .poses
        .iter()
        .filter(|pose| data.runs[pose.run].run == run.run)
        .collect();
    poses.sort_by_key(|pose| pose.node);
    let mut traces = vec![Vec::new(); run.targets.len()];
    let base = context
        .machine
        .chain_motion(&Ideal, &run.outer, &run.positions);
    for pose in poses {
        let shape_mm = &context.poses.bodies[run.body].home_mm;
        for (home, trace) in shape_mm.iter().zip(&mut traces) {
            trace.push(base.inverse() * (context.measured[pose.index] * home));
        }
    }
    traces
}
