//! The error curves and location errors of a scenario by their ISO 230-1 names.

use trueaxis_files::index_of;
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Component, LocationComponent, MICROMETRE};
use trueaxis_kinematics::{FrameRule, LocationError, Machine, MotionError};

use crate::check;
use crate::frame::why_zero;
use crate::gauge::GaugePart;
use crate::plan::PlannedRun;
use crate::true_errors::{Curve, TrueAxis, unit_of};
use crate::{AxisErrors, Error, Gauge, LocationValue, Problem, Scenario};

/// The true errors of every axis of the machine, in the gauge that the scenario asks for.
pub(crate) fn read_errors(
    scenario: &Scenario,
    machine: &Machine,
    runs: &[PlannedRun],
    frame: &FrameRule,
) -> Result<Vec<TrueAxis>, Error> {
    let mut all: Vec<TrueAxis> = machine.axes().iter().map(TrueAxis::faultless).collect();
    let names: Vec<&str> = machine.axes().iter().map(Axis::name).collect();
    for (name, spec) in &scenario.errors {
        let field = format!("errors.{name}");
        let index = index_of(&field, "axis", name, &names)?;
        let (axis, errors) = (&machine.axes()[index], &mut all[index]);
        if *spec == AxisErrors::default() {
            continue;
        }
        errors.curves = curves(&field, axis, spec)?;
        errors.location = location(&field, axis, spec, |component| {
            why_zero(frame, machine, index, component)
        })?;
        errors.half_lost_motion = half_lost_motion(&field, axis, spec)?;
        refuse_unseen_lost_motion(&field, index, axis, errors, runs)?;
        if scenario.gauge == Gauge::LeastSquares {
            errors.gauge = gauge(&field, index, axis, errors, runs)?;
        }
    }
    Ok(all)
}

fn curves(field: &str, axis: &Axis, spec: &AxisErrors) -> Result<[Curve; 6], Error> {
    let names = Component::ALL.map(|component| component.name(axis.name()));
    let known = names.each_ref().map(String::as_str);
    for (name, terms) in &spec.components {
        let field = format!("{field}.components.{name}");
        index_of(&field, "component error", name, &known)?;
        for (i, term) in terms.iter().enumerate() {
            term.check(&format!("{field}[{i}]"), axis.kind())?;
        }
    }
    let terms = |component: Component| spec.components.get(&component.name(axis.name()));
    Ok(Component::ALL.map(|component| Curve {
        terms: terms(component).cloned().unwrap_or_default(),
        unit: unit_of(component),
    }))
}

/// `taken` says why a component is zero by definition of the reference frame, if it is.
fn location(
    field: &str,
    axis: &Axis,
    spec: &AxisErrors,
    taken: impl Fn(LocationComponent) -> Option<String>,
) -> Result<LocationError, Error> {
    let components = axis.location_components();
    let names: Vec<String> = components.iter().map(|c| c.name(axis.name())).collect();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut location = LocationError::default();
    for (name, value) in &spec.location_errors {
        let field = format!("{field}.location_errors.{name}");
        let component = components[index_of(&field, "location error", name, &known)?];
        let (given, unit) = location_value(&field, component, value)?;
        if let Some(reason) = taken(component).filter(|_| given != 0.0) {
            return Err(Problem::TakenByFrame {
                name: name.clone(),
                value: given,
                unit,
                reason,
            }
            .at(field));
        }
        let size = if component.is_angular() { ARCSEC } else { 1.0 };
        *component.of_mut(&mut location) = given * size;
    }
    Ok(location)
}

/// The value, mm or arcsec, and the name of its unit.
fn location_value(
    field: &str,
    component: LocationComponent,
    value: &LocationValue,
) -> Result<(f64, &'static str), Error> {
    let (found, unit, wanted) = match (component, value.value_mm, value.value_arcsec) {
        (LocationComponent::Offset(_), Some(value), None) => (Some(value), "mm", ""),
        (LocationComponent::Tilt(_), None, Some(value)) => (Some(value), "arcsec", ""),
        (LocationComponent::Offset(_), ..) => (None, "mm", "`value_mm` alone for a shift"),
        (LocationComponent::Tilt(_), ..) => (None, "arcsec", "`value_arcsec` alone for a tilt"),
    };
    let found = found.ok_or_else(|| check::expected(field, wanted))?;
    check::finite(field, &[found])?;
    Ok((found, unit))
}

fn half_lost_motion(field: &str, axis: &Axis, spec: &AxisErrors) -> Result<MotionError, Error> {
    let d = axis.direction().into_inner();
    let um = spec.lost_motion_um.map(|b| d * (b / 2.0 * MICROMETRE));
    let arcsec = spec.lost_motion_arcsec.map(|b| d * (b / 2.0 * ARCSEC));
    let wrong = match axis.kind() {
        AxisKind::Linear => arcsec.map(|_| ("lost_motion_arcsec", "`lost_motion_um`", "linear")),
        AxisKind::Rotary => um.map(|_| ("lost_motion_um", "`lost_motion_arcsec`", "rotary")),
    };
    if let Some((name, right, kind)) = wrong {
        let field = format!("{field}.{name}");
        return Err(check::expected(field, format!("{right} for a {kind} axis")));
    }
    let error = MotionError::new(um.unwrap_or_default(), arcsec.unwrap_or_default());
    check::finite(field, error.to_vector().as_slice())?;
    Ok(error)
}

/// Lost motion is ± half about the mean of both directions, so both must be swept.
fn refuse_unseen_lost_motion(
    field: &str,
    index: usize,
    axis: &Axis,
    errors: &TrueAxis,
    runs: &[PlannedRun],
) -> Result<(), Error> {
    if errors.half_lost_motion == MotionError::default() {
        return Ok(());
    }
    let is_one_way = |run: &&PlannedRun| run.axis == index && run.directions.len() < 2;
    runs.iter().find(is_one_way).map_or(Ok(()), |run| {
        let (axis, run) = (axis.name().to_owned(), run.name.clone());
        Err(Problem::LostMotionUnseen { axis, run }.at(field))
    })
}

fn gauge(
    field: &str,
    index: usize,
    axis: &Axis,
    errors: &TrueAxis,
    runs: &[PlannedRun],
) -> Result<GaugePart, Error> {
    let name = axis.name().to_owned();
    if !runs.iter().any(|run| run.axis == index) {
        return Err(Problem::NoRun { axis: name }.at(field));
    }
    let positions = distinct_positions(runs.iter().filter(|run| run.axis == index));
    let given: Vec<MotionError> = positions.iter().map(|&q| errors.as_given(q)).collect();
    let fitted = GaugePart::fit(axis, &positions, &given);
    let (axis, count) = (name, positions.len());
    fitted.ok_or(Problem::GaugeUndefined { axis, count }.at(field))
}

/// The different commanded positions (mm or rad) of runs of one axis, increasing.
pub(crate) fn distinct_positions<'r>(runs: impl Iterator<Item = &'r PlannedRun>) -> Vec<f64> {
    let mut positions: Vec<f64> = runs.flat_map(|run| run.positions.clone()).collect();
    positions.sort_by(f64::total_cmp);
    positions.dedup_by(|a, b| a.total_cmp(b).is_eq());
    positions
}
