//! The extended model as a scenario: the calibrated machine with the causes, measured as in the campaign.
//!
//! Error curves are tables of the calibrated values, already in the least-squares gauge, so that the
//! scenario has the gauge `none`; between the steps they are straight. What a scenario cannot say is told, and
//! one that would measure something else is not made.

use std::collections::BTreeMap;

use trueaxis_calibrate::{AxisResult, Calibration};
use trueaxis_campaign::{Campaign, Direction};
use trueaxis_effects::GivenEffect;
use trueaxis_kinematics::{ARCSEC, Axis, AxisKind, Branch, Component, MICROMETRE};
use trueaxis_simulate::{
    AxisErrors, AxisKindSpec, AxisSpec, Gauge, InstrumentSpec, KinematicsSpec, LocationValue,
    MachineSpec, NoiseSpec, RunSpec, Scenario, StationSpec, Term, Timing, simulate,
};

use crate::diagnose::clock::Clock;
use crate::diagnose::mounting::targets;
use crate::diagnose::order::places_in_replay;

/// A scenario and what it does not say.
pub(crate) struct Replay {
    pub(crate) scenario: Scenario,
    pub(crate) notices: Vec<String>,
}

/// Degrees are written to this, as in `calibration.json`.
const PER_DEGREE: f64 = 1e9;

/// The scenario of a campaign with `effects`, or why there is none.
pub(crate) fn replay(
    campaign: &Campaign,
    calibration: &Calibration,
    effects: &[GivenEffect],
) -> Result<Replay, String> {
    let Some(lengths) = &campaign.lengths else {
        return Err("only lengths can be replayed".to_owned());
    };
    if effects.iter().any(|e| e.effect == "timestamp_offset") {
        return Err(
            "late time stamps need a moving machine, and the simulated one stands still \
                    at its stops"
                .to_owned(),
        );
    }
    let mut scenario = Scenario {
        format: Scenario::FORMAT.to_owned(),
        version: Scenario::VERSION,
        name: campaign.name.clone(),
        machine: machine(campaign),
        instrument: InstrumentSpec {
            name: campaign.instrument.name.clone(),
            length_sigma_um: campaign.instrument.length_sigma_um,
            length_sigma_ppm: campaign.instrument.length_sigma_ppm,
            repeatability_um: campaign.instrument.repeatability_um,
        },
        targets: targets(campaign, calibration)?,
        stations: stations(campaign, calibration)?,
        errors: calibration
            .axes
            .iter()
            .map(errors)
            .collect::<BTreeMap<_, _>>(),
        gauge: Gauge::None,
        effects: effects.to_vec(),
        runs: runs(campaign)?,
        repeats: lengths
            .stops
            .iter()
            .map(|stop| stop.repeat)
            .max()
            .unwrap_or(1),
        noise: noise(calibration),
        timing: Timing::default(),
    };
    let simulated = |scenario: &Scenario| {
        let simulated = simulate(scenario, 1).map_err(|error| error.to_string())?;
        Ok::<_, String>(simulated.campaign)
    };
    let evenly = simulated(&scenario)?;
    let places = places_in_replay(campaign, &evenly)?;
    let mut notices = Vec::new();
    let missing = evenly.lengths.as_ref().map_or(0, |l| l.readings.len()) - places.len();
    if missing > 0 {
        notices.push(format!(
            "replay.json also measures {missing} lengths that the campaign does not have"
        ));
    }
    scenario.timing = Clock::of(campaign, &evenly, &places).timing();
    let clock = Clock::of(campaign, &simulated(&scenario)?, &places);
    clock.set_instants(&mut scenario.effects);
    notices.extend(clock.notice());
    if !campaign.verification.is_empty() {
        notices.push("replay.json has the lengths only, no verification".to_owned());
    }
    simulated(&scenario)?;
    Ok(Replay { scenario, notices })
}

/// mm or degrees.
fn in_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position,
        AxisKind::Rotary => (position.to_degrees() * PER_DEGREE).round() / PER_DEGREE,
    }
}

fn machine(campaign: &Campaign) -> MachineSpec {
    let machine = &campaign.machine;
    let branch = |branch| {
        let axes = machine.branch(branch).iter();
        axes.map(|&axis| machine.axes()[axis].name().to_owned())
            .collect()
    };
    let axis = |axis: &Axis| {
        let rotary = axis.kind() == AxisKind::Rotary;
        AxisSpec {
            name: axis.name().to_owned(),
            kind: match axis.kind() {
                AxisKind::Linear => AxisKindSpec::Linear,
                AxisKind::Rotary => AxisKindSpec::Rotary,
            },
            direction: axis.direction().into_inner().into(),
            travel: axis.travel().map(|q| in_file(axis.kind(), q)),
            position_mm: rotary.then(|| axis.reference_mm().into()),
        }
    };
    MachineSpec {
        name: campaign.machine_name.clone(),
        kinematics: KinematicsSpec {
            tool: branch(Branch::Tool),
            workpiece: branch(Branch::Workpiece),
        },
        axes: machine.axes().iter().map(axis).collect(),
    }
}

fn stations(campaign: &Campaign, calibration: &Calibration) -> Result<Vec<StationSpec>, String> {
    if !calibration.adjustment.interruptions.is_empty() {
        return Err("the calibration split turns of stations, which a scenario cannot".to_owned());
    }
    let found = campaign.stations.iter().zip(&calibration.stations);
    let stations = found.map(|(declared, found)| StationSpec {
        name: found.name.clone(),
        position_mm: found.position_mm.into(),
        dead_path_mm: found.dead_path_mm,
        declare_approx: declared.approx_mm.is_some(),
    });
    Ok(stations.collect())
}

/// The curves as tables, and the location errors.
fn errors(axis: &AxisResult) -> (String, AxisErrors) {
    let table = |component: Component| {
        let unit = if component.is_angular() {
            ARCSEC
        } else {
            MICROMETRE
        };
        let nodes = axis.nodes.iter();
        let values = nodes.map(|node| node.error.to_vector()[component.index()] / unit);
        let positions = axis
            .nodes
            .iter()
            .map(|node| in_file(axis.kind, node.position));
        let term = Term::Table {
            positions: positions.collect(),
            values: values.collect(),
        };
        (component.name(&axis.name), vec![term])
    };
    let location = axis.location_errors.iter().map(|location| {
        let angular = location.component.is_angular();
        let value = LocationValue {
            value_arcsec: angular.then_some(location.value / ARCSEC),
            value_mm: (!angular).then_some(location.value),
        };
        (location.component.name(&axis.name), value)
    });
    let errors = AxisErrors {
        components: Component::ALL.into_iter().map(table).collect(),
        location_errors: location.collect(),
        ..AxisErrors::default()
    };
    (axis.name.clone(), errors)
}

fn runs(campaign: &Campaign) -> Result<Vec<RunSpec>, String> {
    let runs = campaign.runs.iter().enumerate();
    runs.map(|(number, run)| {
        let axes = campaign.machine.axes();
        let own = &axes[run.axis];
        let steps: Vec<&Vec<f64>> = campaign
            .steps
            .iter()
            .filter(|step| step.run == number)
            .map(|step| &step.positions)
            .collect();
        let mut positions: Vec<f64> = steps
            .iter()
            .map(|q| in_file(own.kind(), q[run.axis]))
            .collect();
        positions.sort_by(f64::total_cmp);
        let mut parked = BTreeMap::new();
        for (index, axis) in axes.iter().enumerate().filter(|(i, _)| *i != run.axis) {
            let first = steps.first().map_or(0.0, |q| q[index]);
            if steps.iter().any(|q| q[index].total_cmp(&first).is_ne()) {
                return Err(format!("in run {} more than one axis moves", run.name));
            }
            parked.insert(axis.name().to_owned(), in_file(axis.kind(), first));
        }
        let (targets, directions) = targets_and_directions(campaign, number);
        Ok(RunSpec {
            name: run.name.clone(),
            axis: own.name().to_owned(),
            positions: Some(positions),
            sweep: None,
            parked,
            targets: Some(targets),
            directions,
        })
    })
    .collect()
}

/// Of a run, in the order in which they first appear.
fn targets_and_directions(campaign: &Campaign, run: usize) -> (Vec<String>, Vec<i8>) {
    let (mut targets, mut directions) = (Vec::new(), Vec::new());
    if let Some(lengths) = &campaign.lengths {
        let stops = lengths.stops.iter();
        for stop in stops.filter(|stop| campaign.steps[stop.step].run == run) {
            let direction = match stop.direction {
                Direction::Forward => 1,
                Direction::Backward => -1,
            };
            if !directions.contains(&direction) {
                directions.push(direction);
            }
            for reading in &lengths.readings[stop.readings.clone()] {
                let name = &campaign.targets[reading.target].name;
                if !targets.contains(name) {
                    targets.push(name.clone());
                }
            }
        }
    }
    (targets, directions)
}

/// The estimated noise.
fn noise(calibration: &Calibration) -> NoiseSpec {
    let noise = calibration.adjustment.noise;
    NoiseSpec {
        length_sigma_um: noise.map(|n| n.length.used.sigma_mm / MICROMETRE),
        length_sigma_ppm: noise.map(|n| n.length_ppm),
        repeatability_um: noise.map(|n| n.machine_return.used.sigma_mm / MICROMETRE),
        exact: false,
    }
}
