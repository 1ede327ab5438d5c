//! From a campaign and what is believed of it to a scenario: the inverse of [`simulate()`](crate::simulate()).
//!
//! Error curves are tables of the believed values, which are in the least-squares gauge already, so that
//! the scenario has the gauge `none`; between the steps they are straight. What a scenario cannot express
//! is reported, and one that would measure something else is not made.

mod clock;
mod order;
mod targets;
mod temperatures;

use std::collections::BTreeMap;

use trueaxis_campaign::{Campaign, MachineSpec};
use trueaxis_effects::{GivenEffect, GivenParameter, GivenSubject};
use trueaxis_files::{counted, round};
use trueaxis_kinematics::{ARCSEC, AxisKind, Component};

use crate::true_errors::unit_of;
use crate::{
    AxisErrors, BedSpec, Error, Gauge, LocationValue, NoiseSpec, RunSpec, Scenario, StationSpec,
    SystematicSpec, Term, Timing, TrueComponents, TrueLocation, Truth, simulate,
};
use clock::Clock;
use order::places_in_replay;
use targets::targets;
use temperatures::temperatures;

/// A scenario and what it does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// The scenario: simulated, it measures what the campaign measured.
    pub scenario: Scenario,
    /// In words for the user.
    pub notices: Vec<String>,
}

/// Why a campaign cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The campaign has no lengths.
    #[error("only lengths can be replayed")]
    NoLengths,
    /// The simulated machine stands still at its stops.
    #[error(
        "late time stamps need a moving machine, and the simulated one stands still at its stops"
    )]
    LateTimeStamps,
    /// A run with more than one moving axis.
    #[error("in run {run} more than one axis moves")]
    SeveralAxesMove {
        /// Name of the run.
        run: String,
    },
    /// A simulated campaign has one order.
    #[error(
        "its lengths were measured in another order than stations, repeats, runs, sweeps, \
         positions, targets"
    )]
    OtherOrder,
    /// A target of the campaign of which nothing is believed.
    #[error("target {target} was not measured")]
    TargetNotMeasured {
        /// Name of the target.
        target: String,
    },
    /// The targets are not where the reference frame of a scenario would have them.
    #[error(
        "the frame of the calibration has directions that a scenario takes from its targets \
         (they are off by {off:.1e} mm or rad, expected at most {most:.0e})"
    )]
    OtherFrame {
        /// Shift, mm, or rotation, rad, of the targets against the frame.
        off: f64,
        /// What an iterated frame may leave.
        most: f64,
    },
    /// The scenario cannot be simulated.
    #[error(transparent)]
    Scenario(#[from] Error),
}

/// The scenario that measures `campaign` again if `truth` is true of it.
///
/// # Errors
/// [`ReplayError`] if no scenario would measure the same in the same order.
pub fn replay(campaign: &Campaign, truth: &Truth) -> Result<Replay, ReplayError> {
    let lengths = campaign.lengths.as_ref().ok_or(ReplayError::NoLengths)?;
    if truth.effects.iter().any(|e| e.effect == "timestamp_offset") {
        return Err(ReplayError::LateTimeStamps);
    }
    let axes = truth.axes.iter();
    let errors = axes.map(|axis| (axis.name.clone(), errors(truth, axis)));
    let repeats = lengths.stops.iter().map(|stop| stop.repeat);
    let mut scenario = Scenario {
        format: Scenario::FORMAT.name.to_owned(),
        version: Scenario::FORMAT.version,
        name: campaign.name.clone(),
        machine: MachineSpec::of(&campaign.machine_name, &campaign.machine),
        instrument: campaign.instrument.clone(),
        targets: targets(campaign, truth)?,
        stations: stations(campaign, truth),
        errors: errors.collect(),
        gauge: Gauge::None,
        effects: truth.effects.iter().cloned().chain(scale(truth)).collect(),
        runs: runs(campaign)?,
        repeats: repeats.max().unwrap_or(1),
        bed: bed(campaign),
        noise: NoiseSpec {
            length_sigma_um: Some(truth.noise.length_sigma_um),
            length_sigma_ppm: Some(truth.noise.length_sigma_ppm),
            repeatability_um: Some(truth.noise.repeatability_um),
            exact: false,
        },
        systematic: systematic(campaign),
        reflectors: truth.reflectors.clone(),
        known_lengths: Vec::new(),
        temperatures: temperatures(campaign, truth),
        timing: Timing::default(),
    };
    let simulated = |scenario: &Scenario| simulate(scenario, 1).map(|simulated| simulated.campaign);
    let evenly = simulated(&scenario)?;
    let places = places_in_replay(campaign, &evenly)?;
    let mut notices = Vec::new();
    let missing = evenly.lengths.as_ref().map_or(0, |l| l.readings.len()) - places.len();
    if missing > 0 {
        notices.push(format!(
            "replay.json also measures {} that the campaign does not have",
            counted(missing, "length")
        ));
    }
    scenario.timing = Clock::of(campaign, &evenly, &places).timing();
    let clock = Clock::of(campaign, &simulated(&scenario)?, &places);
    clock.set_instants(&mut scenario.effects);
    notices.extend(clock.notice());
    if !campaign.verification.is_empty() || !campaign.point_checks.is_empty() {
        notices.push("replay.json has the lengths only, no verification".to_owned());
    }
    simulated(&scenario)?;
    Ok(Replay { scenario, notices })
}

/// What is declared as uncertain is not drawn again: the replay has what is believed of it.
fn systematic(campaign: &Campaign) -> SystematicSpec {
    let instrument = &campaign.instrument;
    let of_instrument = instrument.reflector_sigma_um.or(instrument.scale_sigma_ppm);
    let mut targets = campaign.targets.iter();
    match of_instrument.is_some() || targets.any(|t| t.position_sigma_mm.is_some()) {
        true => SystematicSpec::NONE,
        false => SystematicSpec::default(),
    }
}

/// The scale of all lengths, as an effect.
fn scale(truth: &Truth) -> Option<GivenEffect> {
    let has_scale = truth.scale_ppm.abs() > 0.0;
    has_scale.then(|| GivenEffect {
        effect: "length_scale".to_owned(),
        subject: GivenSubject::default(),
        parameters: vec![GivenParameter {
            name: "scale".to_owned(),
            value: truth.scale_ppm,
            u: None,
            unit: "ppm".to_owned(),
        }],
    })
}

/// mm or, to nine decimals as in `calibration.json`, degrees.
fn in_file(kind: AxisKind, position: f64) -> f64 {
    match kind {
        AxisKind::Linear => position,
        AxisKind::Rotary => round(position.to_degrees(), 9),
    }
}

fn stations(campaign: &Campaign, truth: &Truth) -> Vec<StationSpec> {
    let stations = campaign.stations.iter().zip(&truth.stations);
    let stations = stations.map(|(declared, found)| StationSpec {
        name: found.name.clone(),
        position_mm: found.position_mm.into(),
        dead_path_mm: found.dead_path_mm,
        declare_approx: declared.approx_mm.is_some(),
        dead_path_sigma_mm: None,
    });
    stations.collect()
}

/// The curves as tables, and the location errors.
fn errors(truth: &Truth, axis: &TrueComponents) -> AxisErrors {
    let table = |component: Component| {
        let unit = unit_of(component);
        let values = axis.errors.iter();
        let positions = axis.positions.iter();
        let term = Term::Table {
            positions: positions.map(|&q| in_file(axis.kind, q)).collect(),
            values: values
                .map(|e| e.to_vector()[component.index()] / unit)
                .collect(),
        };
        (component.name(&axis.name), vec![term])
    };
    let own = |location: &&TrueLocation| location.component.name(&axis.name) == location.name;
    let location = truth.location_errors.iter().filter(own).map(|location| {
        let angular = location.component.is_angular();
        let value = LocationValue {
            value_arcsec: angular.then_some(location.value / ARCSEC),
            value_mm: (!angular).then_some(location.value),
        };
        (location.name.clone(), value)
    });
    AxisErrors {
        components: Component::ALL.into_iter().map(table).collect(),
        location_errors: location.collect(),
        ..AxisErrors::default()
    }
}

fn runs(campaign: &Campaign) -> Result<Vec<RunSpec>, ReplayError> {
    let runs = campaign.runs.iter().enumerate();
    runs.map(|(number, run)| {
        let axes = campaign.machine.axes();
        let own = &axes[run.axis];
        let steps = campaign
            .steps
            .iter()
            .filter(|step| step.run == Some(number));
        let steps: Vec<&Vec<f64>> = steps.map(|step| &step.positions).collect();
        let positions = steps.iter().map(|q| in_file(own.kind(), q[run.axis]));
        let mut positions: Vec<f64> = positions.collect();
        positions.sort_by(f64::total_cmp);
        let mut parked = BTreeMap::new();
        for (index, axis) in axes.iter().enumerate().filter(|(i, _)| *i != run.axis) {
            let first = steps.first().map_or(0.0, |q| q[index]);
            if steps.iter().any(|q| q[index].total_cmp(&first).is_ne()) {
                let run = run.name.clone();
                return Err(ReplayError::SeveralAxesMove { run });
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

/// How often the targets on the bed are read from a station.
fn bed(campaign: &Campaign) -> Option<BedSpec> {
    let lengths = campaign.lengths.iter().flat_map(|lengths| &lengths.stops);
    let on_bed = lengths.filter(|stop| campaign.steps[stop.step].run.is_none());
    let mut counts = vec![0; campaign.stations.len()];
    on_bed.for_each(|stop| counts[stop.station] += 1);
    let readings = counts.into_iter().max().filter(|&count| count > 0)?;
    Some(BedSpec { readings })
}

/// Of a run, in the order in which they first appear.
fn targets_and_directions(campaign: &Campaign, run: usize) -> (Vec<String>, Vec<i8>) {
    let (mut targets, mut directions) = (Vec::new(), Vec::new());
    if let Some(lengths) = &campaign.lengths {
        let stops = lengths.stops.iter();
        for stop in stops.filter(|stop| campaign.steps[stop.step].run == Some(run)) {
            let direction = stop.direction.sign();
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
