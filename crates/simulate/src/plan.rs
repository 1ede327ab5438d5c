//! The checked scenario: names resolved, units of the kinematics, errors in their gauge.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};
use trueaxis_campaign::{AxisExpansion, Target, frame_rule};
use trueaxis_effects::{ResolvedEffect, Scene, SceneTarget, resolve_all};
use trueaxis_files::index_of;
use trueaxis_kinematics::{Axis, FrameRule, Machine};

use crate::check;
use crate::mounting::check_mounting;
use crate::plan_bed::{PlannedBed, plan_bed};
use crate::plan_runs::plan_runs;
use crate::read_errors::read_errors;
use crate::systematic::PlannedSystematic;
use crate::temperature::{check_expansions, check_temperatures, scene_temperatures};
use crate::true_errors::TrueAxis;
use crate::{Error, Noise, Problem, Scenario};

pub(crate) use crate::plan_runs::PlannedRun;

/// Everything that a simulation needs beside stations and clock.
pub(crate) struct Plan {
    pub(crate) machine: Machine,
    /// As the campaign declares them.
    pub(crate) targets: Vec<Target>,
    /// Where they truly are at home.
    pub(crate) homes_mm: Vec<Point3<f64>>,
    pub(crate) runs: Vec<PlannedRun>,
    pub(crate) bed: PlannedBed,
    pub(crate) frame: FrameRule,
    pub(crate) errors: Vec<TrueAxis>,
    pub(crate) noise: Noise,
    pub(crate) effects: Vec<ResolvedEffect>,
    pub(crate) systematic: PlannedSystematic,
    pub(crate) expansions: Vec<AxisExpansion>,
}

impl Plan {
    pub(crate) fn new(scenario: &Scenario) -> Result<Self, Error> {
        if scenario.repeats == 0 {
            return Err(check::expected("repeats", "at least 1"));
        }
        let machine = scenario.machine.build().map_err(Problem::of_campaign)?;
        let targets = plan_targets(scenario, &machine)?;
        let mounted = scenario.targets.iter().zip(&targets);
        let mounted =
            mounted.map(|(own, target)| target.home_mm + Vector3::from(own.mounting_error_mm));
        let homes_mm: Vec<Point3<f64>> = mounted.collect();
        check_stations(scenario)?;
        let runs = plan_runs(scenario, &machine, &targets)?;
        let bed = plan_bed(scenario, &targets, &runs)?;
        check_timing(scenario)?;
        let measured = runs.iter();
        let measured =
            measured.flat_map(|run| run.targets.iter().map(|&target| (run.axis, target)));
        let frame = frame_rule(&machine, &targets, measured);
        let errors = read_errors(scenario, &machine, &runs, &frame)?;
        check_mounting(&frame, &targets, &homes_mm)?;
        let noise = Noise::of(scenario)?;
        check_temperatures(scenario)?;
        let scene = scene(scenario, &machine, &targets, &runs);
        let effects = resolve_all(&scenario.effects, &scene)
            .map_err(|error| Problem::Effect(error.problem).in_place(error.place))?;
        let systematic = PlannedSystematic::new(scenario, &targets)?;
        let expansions = scenario
            .machine
            .expansions()
            .map_err(Problem::of_campaign)?;
        check_expansions(scenario, &expansions)?;
        Ok(Self {
            machine,
            targets,
            homes_mm,
            runs,
            bed,
            frame,
            errors,
            noise,
            effects,
            systematic,
            expansions,
        })
    }
}

fn plan_targets(scenario: &Scenario, machine: &Machine) -> Result<Vec<Target>, Error> {
    let axes: Vec<&str> = machine.axes().iter().map(Axis::name).collect();
    let names: Vec<&str> = scenario.targets.iter().map(|t| t.name.as_str()).collect();
    check::distinct_names("targets", "target", &names)?;
    let targets = scenario.targets.iter().enumerate();
    targets
        .map(|(i, target)| {
            let field = |name: &str| format!("targets[{i}].{name}");
            check::finite(&field("position_mm"), &target.position_mm)?;
            check::finite(&field("mounting_error_mm"), &target.mounting_error_mm)?;
            if let Some(sigma_mm) = target.position_sigma_mm {
                check::positive(&field("position_sigma_mm"), sigma_mm)?;
            }
            let carrier = target.carried_by.as_ref();
            let carrier = carrier.map(|name| index_of(field("carried_by"), "axis", name, &axes));
            Ok(Target {
                name: target.name.clone(),
                home_mm: Point3::from(target.position_mm),
                carrier: carrier.transpose()?,
                reflector: target.reflector.clone(),
                position_sigma_mm: target.position_sigma_mm,
            })
        })
        .collect()
}

fn check_stations(scenario: &Scenario) -> Result<(), Error> {
    let names: Vec<&str> = scenario.stations.iter().map(|s| s.name.as_str()).collect();
    check::distinct_names("stations", "station", &names)?;
    for (i, station) in scenario.stations.iter().enumerate() {
        let field = |name: &str| format!("stations[{i}].{name}");
        check::finite(&field("position_mm"), &station.position_mm)?;
        check::finite(&field("dead_path_mm"), &[station.dead_path_mm])?;
        if let Some(sigma_mm) = station.dead_path_sigma_mm {
            check::positive(&field("dead_path_sigma_mm"), sigma_mm)?;
        }
    }
    Ok(())
}

/// What the effects can happen to.
fn scene(scenario: &Scenario, machine: &Machine, targets: &[Target], runs: &[PlannedRun]) -> Scene {
    let moving: BTreeSet<usize> = runs.iter().map(|run| run.axis).collect();
    let targets = targets.iter().map(|target| SceneTarget {
        name: target.name.clone(),
        carrier: target.carrier,
    });
    Scene {
        machine: machine.clone(),
        stations: scenario.stations.iter().map(|s| s.name.clone()).collect(),
        targets: targets.collect(),
        moving: moving.into_iter().collect(),
        temperatures: scene_temperatures(scenario),
    }
}

fn check_timing(scenario: &Scenario) -> Result<(), Error> {
    let timing = &scenario.timing;
    let durations = [
        ("timing.start_s", timing.start_s),
        ("timing.per_reading_s", timing.per_reading_s),
        ("timing.per_move_s", timing.per_move_s),
        ("timing.per_station_change_s", timing.per_station_change_s),
    ];
    durations
        .iter()
        .try_for_each(|(field, seconds)| check::not_negative(field, *seconds))
}
