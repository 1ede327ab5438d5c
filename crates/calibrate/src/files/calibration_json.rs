//! `calibration.json`, version 1.
//!
//! Positions are mm or degrees, linear errors µm, angular errors arcsec; `u` is a standard
//! uncertainty. Numbers are rounded far below anything measurable, so that the file reads well.

use nalgebra::Point3;
use serde::Serialize;
use serde_json::{Value, json};
use trueaxis_campaign::Direction;
use trueaxis_files::{round, significant, value_to_json, without_nulls};
use trueaxis_kinematics::{ARCSEC, Component, MICROMETRE, Machine};
use trueaxis_poses::{
    KnownMisfit, Method, ReflectorConstant, ScaleBasis, ScaleResult, SideDifference, StepMisfit,
    TurnedRuns,
};

use crate::files::adjustment_json::adjustment;
use crate::files::unless_empty;
use crate::result::budget::Budget;
use crate::result::calibration::{
    AxisResult, Calibration, LocationResult, RelativeLocation, RelativeQuantity, RunMisfit,
    StationResult, TargetResult, Traceability, TriangleSide,
};
use trueaxis_predict::{Unit, position_in_file, positions_in_file};

impl Calibration {
    /// The text of `calibration.json`, version 1.
    ///
    /// `docs/formats.md` describes its fields; empty ones are left out.
    pub fn to_json(&self) -> String {
        let target =
            |t: &TargetResult| json!({ "name": t.name, "position_mm": point(t.position_mm) });
        let locations = self.axes.iter().flat_map(|axis| {
            let errors = axis.location_errors.iter();
            errors.map(|error| (error.component.name(&axis.name), location_error(error)))
        });
        let misfits = self.misfits.iter().map(misfit_of_step);
        let misfits = misfits.chain(self.axes.iter().filter_map(misfit_of_runs));
        let misfits = misfits.chain(self.turned_runs.iter().map(misfit_of_turned));
        let misfits = misfits.chain(self.known_misfits.iter().map(misfit_of_known));
        value_to_json(&without_nulls(json!({
            "format": "trueaxis-calibration",
            "version": 1,
            "campaign": self.campaign,
            "machine": self.machine_spec,
            "method": match self.method {
                Method::Joint => "joint".to_owned(),
                Method::Nine => "nine-equation".to_owned(),
                Method::Six(rows) => format!("six-equation {rows}"),
            },
            "adjustment": adjustment(&self.adjustment),
            "stations": self.stations.iter().map(station).collect::<Value>(),
            "reflectors": unless_empty(&self.reflectors, reflector),
            "scale": self.scale.map(scale),
            "uncertainty_contains": self.uncertainty.contains,
            "uncertainty_lacks": self.uncertainty.lacks,
            "targets": self.targets.iter().map(target).collect::<Value>(),
            "axes": self.axes.iter().map(|own| axis(own, &self.machine)).collect::<Value>(),
            "location_errors": locations.collect::<Value>(),
            "relative_locations": unless_empty(&self.relative_locations, relative_location),
            "misfits": misfits.collect::<Value>(),
            "triangle": self.triangle.iter().map(side).collect::<Value>(),
            "effects_taken_out": unless_empty(&self.effects, |effect| json!(effect)),
            "notices": self.notices,
            "traceability": traceability(&self.traceability),
        })))
    }
}

fn traceability(of: &Traceability) -> Value {
    without_nulls(json!({
        "date": of.date,
        "operator": of.operator,
        "instrument": (!of.instrument.is_empty()).then_some(&of.instrument),
        "serial": of.serial,
        "program": concat!("trueaxis ", env!("CARGO_PKG_VERSION")),
        "inputs": unless_empty(&of.inputs, |input| json!(input)),
    }))
}

fn mm(value: f64) -> f64 {
    Unit::Millimetre.in_file(value)
}

fn point(point_mm: Point3<f64>) -> [f64; 3] {
    point_mm.map(mm).into()
}

fn station(station: &StationResult) -> Value {
    json!({
        "name": station.name,
        "position_mm": point(station.position_mm),
        "u_mm": station.u_mm.map(mm),
        "dead_path_mm": mm(station.dead_path_mm),
        "u_dead_path_mm": mm(station.u_dead_path_mm),
    })
}

fn reflector(reflector: &ReflectorConstant) -> Value {
    let correlation = reflector.correlation.iter();
    json!({
        "name": reflector.name,
        "constant_um": Unit::Micrometre.in_file(reflector.constant_mm),
        "u_um": Unit::Micrometre.in_file(reflector.u_mm),
        "correlation": correlation.map(|r| round(*r, 4)).collect::<Value>(),
    })
}

fn scale(scale: ScaleResult) -> Value {
    json!({
        "value_ppm": round(scale.value * 1e6, 4),
        "u_ppm": round(scale.u * 1e6, 4),
        "basis": match scale.basis {
            ScaleBasis::Declared => "declared",
            ScaleBasis::KnownLengths => "known lengths",
            ScaleBasis::Both => "known lengths and declared",
        },
    })
}

fn axis(axis: &AxisResult, machine: &Machine) -> Value {
    let nodes = axis.nodes.iter();
    let positions = nodes
        .clone()
        .map(|node| position_in_file(axis.kind, node.position));
    let directions = nodes.filter_map(|node| node.direction).map(Direction::sign);
    let directions: Vec<i8> = directions.collect();
    without_nulls(json!({
        "name": axis.name,
        "kind": axis.kind.name(),
        "unit": axis.kind.position_unit(),
        "positions": positions.collect::<Value>(),
        "direction": (!directions.is_empty()).then_some(directions),
        "reference_point_mm": point(axis.reference_point_mm),
        "parked": positions_in_file(machine, &axis.parked),
        "components": by_component(axis, |c| curve(axis, c)),
        "noise_gain": axis.noise_gain.map(|gains| by_component(axis, |c| noise_gain(&gains, c))),
        "u_ratio": axis.u_ratio.map(|loss| {
            by_component(axis, |c| without_nulls(json!({
                "nine": round(loss.nine[c.index()], 4),
                "six": loss.six.map(|six| round(six[c.index()], 4)),
            })))
        }),
        "run_misfit": axis.runs.as_ref().map(|runs| run_misfit(axis, runs)),
        "forward_minus_backward": axis.sides.map(|sides| json!({
            "p_value": significant(sides.p_value),
            "components": by_component(axis, |c| side_difference(&sides, c)),
        })),
    }))
}

fn run_misfit(axis: &AxisResult, runs: &RunMisfit) -> Value {
    let unit = Unit::of_component(runs.component);
    json!({
        "runs": runs.runs,
        "chi_squared": round(runs.chi_squared, 3),
        "degrees_of_freedom": runs.degrees_of_freedom,
        "p_value": significant(runs.p_value),
        "birge_ratio": round(runs.birge_ratio(), 4),
        "largest": {
            "component": runs.component.name(&axis.name),
            "position": position_in_file(axis.kind, runs.position),
            (format!("difference_{}", unit.suffix())): unit.in_file(runs.difference),
        },
    })
}

/// One entry for each of the six components, by their names.
fn by_component(axis: &AxisResult, entry: impl Fn(Component) -> Value) -> Value {
    let entries = Component::ALL.into_iter();
    entries
        .map(|component| (component.name(&axis.name), entry(component)))
        .collect()
}

/// `value_um` and `u_um`, or the same in another unit, with the evidence for the uncertainties: the least degrees of
/// freedom, and the mean shares of the budget over all values that gauge or frame do not define.
fn quantity(
    unit: Unit,
    value: impl Serialize,
    u: impl Serialize,
    behind: impl Iterator<Item = (f64, Budget)>,
) -> Value {
    let mut least = f64::INFINITY;
    let (mut sums, mut count) = ([0.0; 5], 0.0);
    for (dof, budget) in behind {
        least = least.min(dof);
        if let Some(shares) = budget.shares() {
            for (sum, share) in sums.iter_mut().zip(shares) {
                *sum += share;
            }
            count += 1.0;
        }
    }
    let shares = sums.map(|sum| round(sum / count, 4));
    let [laser, repeatability, station_geometry, systematic, effects] = shares;
    let budget = without_nulls(json!({
        "laser": laser,
        "machine_return": repeatability,
        "station_geometry": station_geometry,
        "systematic": (systematic > 0.0).then_some(systematic),
        "effects": (effects > 0.0).then_some(effects),
    }));
    without_nulls(json!({
        (format!("value_{}", unit.suffix())): value,
        (format!("u_{}", unit.suffix())): u,
        "dof": least.is_finite().then(|| round(least, 1)),
        "budget": (count > 0.0).then_some(budget),
    }))
}

fn curve(axis: &AxisResult, component: Component) -> Value {
    let (c, unit) = (component.index(), Unit::of_component(component));
    let (nodes, in_file) = (axis.nodes.iter(), |value| unit.in_file(value));
    let values = nodes.clone().map(|n| in_file(n.error.to_vector()[c]));
    let u = nodes.clone().map(|n| in_file(n.u[c]));
    let behind = nodes.map(|n| (n.dof[c], n.budget[c]));
    quantity(
        unit,
        values.collect::<Value>(),
        u.collect::<Value>(),
        behind,
    )
}

/// The fields of one value and its u, mm or rad.
fn one(unit: Unit, values: [f64; 2], behind: Option<(f64, Budget)>) -> Value {
    let [value, u] = values.map(|x| unit.in_file(x));
    quantity(unit, value, u, behind.into_iter())
}

fn location_error(error: &LocationResult) -> Value {
    let unit = Unit::of_location(error.component);
    let mut entry = one(
        unit,
        [error.value, error.u],
        Some((error.dof, error.budget)),
    );
    if error.relative_to_targets {
        entry["relative_to"] = json!("targets");
    }
    entry
}

fn relative_location(relative: &RelativeLocation) -> Value {
    let found =
        |unit: Unit, of: &RelativeQuantity| one(unit, [of.value, of.u], Some((of.dof, of.budget)));
    json!({
        "axis": relative.axis,
        "to": relative.to,
        "direction": relative.direction.map(|x| round(x, 9)).as_slice(),
        "offset": found(Unit::Millimetre, &relative.offset),
        "angle": found(Unit::Arcsec, &relative.angle),
    })
}

fn side_difference(sides: &SideDifference, component: Component) -> Value {
    let c = component.index();
    one(
        Unit::of_component(component),
        [sides.value[c], sides.u[c]],
        None,
    )
}

/// µm or arcsec for 1 µm of independent noise on every coordinate, by the method used and by the nine equations.
fn noise_gain([used, nine]: &[[f64; 6]; 2], component: Component) -> Value {
    // mm per mm is µm per µm; rad per mm becomes arcsec per µm.
    let unit = match component.is_angular() {
        true => MICROMETRE / ARCSEC,
        false => 1.0,
    };
    let [used, nine] = [used, nine].map(|gain| round(gain[component.index()] * unit, 4));
    json!({ "used": used, "nine": nine })
}

fn misfit(what: &str, rms_um: f64, chi_squared: f64, dof: usize, p_value: f64) -> Value {
    json!({
        "step": what,
        "rms_um": round(rms_um, 3),
        "chi_squared": round(chi_squared, 3),
        "degrees_of_freedom": dof,
        "p_value": significant(p_value),
    })
}

fn misfit_of_step(of: &StepMisfit) -> Value {
    let dof = of.degrees_of_freedom;
    misfit(&of.step, of.rms_um, of.chi_squared, dof, of.p_value)
}

/// The entry of runs that contradict each other.
fn misfit_of_runs(axis: &AxisResult) -> Option<Value> {
    let of = axis.runs.as_ref()?;
    let what = format!("axis {}: runs {}", axis.name, of.runs.join(", "));
    let (rms_um, dof) = (of.rms_mm / MICROMETRE, of.degrees_of_freedom);
    Some(misfit(&what, rms_um, of.chi_squared, dof, of.p_value))
}

fn misfit_of_turned(of: &TurnedRuns) -> Value {
    let what = format!("runs {} against each other, turned", of.runs.join(" and "));
    let (rms_um, dof) = (of.moved_mm / MICROMETRE, of.degrees_of_freedom);
    misfit(&what, rms_um, of.chi_squared, dof, of.p_value)
}

fn misfit_of_known(of: &KnownMisfit) -> Value {
    let rms_um = of.difference_mm.abs() / MICROMETRE;
    misfit(&of.what, rms_um, of.chi_squared, 1, of.p_value)
}

fn side(side: &TriangleSide) -> Value {
    json!({
        "targets": side.targets,
        "nominal_mm": mm(side.nominal_mm),
        "measured_mm": mm(side.measured_mm),
        "difference_um": round((side.measured_mm - side.nominal_mm) / MICROMETRE, 3),
    })
}
