//! From a scenario to the campaign that would be measured.

use nalgebra::Point3;
use trueaxis_campaign::{
    Campaign, KnownDeadPath, LengthReading, Lengths, Run, Station, Step, Stop,
};
use trueaxis_effects::ResolvedEffect;

use crate::circumstances::{Progress, StopCircumstances};
use crate::noise::Deviates;
use crate::plan::Plan;
use crate::schedule::{Visit, schedule};
use crate::systematic::{Systematic, known_dead_paths};
use crate::temperature::{self, Expansions, true_histories};
use crate::true_errors::Sweeping;
use crate::{Error, Scenario, StationSpec, Truth};

/// A simulated campaign and what is true of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// What was measured.
    pub campaign: Campaign,
    /// What an estimator should find.
    pub truth: Truth,
}

/// Lengths are given in steps of 1e-7 mm, a thousandth of the best interferometer's resolution.
const LENGTHS_PER_MM: f64 = 1e7;
/// Declared station positions are paced off, mm.
const PACE_MM: f64 = 100.0;

/// Measures the scenario's machine with the scenario's instrument.
///
/// Each length is `|p + d + D_p - S - D_S| (1 + s) + c - L + D_l + e`: p is the exact position of the
/// target on the erroneous machine, d the machine's random deviation at the stop (common to its targets),
/// S and L are the station and its dead path, s is the instrument's scale and c the reflector's constant,
/// e is the instrument's noise, and the D are the sums of what the scenario's effects do to target,
/// station and display. Targets on the bed have no d. The order is stations, repeats, runs, directions, positions,
/// targets, with those on the bed before, between and after the sweeps of each station; the same
/// seed gives the same campaign, and effects change neither its order, its times nor its deviates.
///
/// # Errors
/// If the scenario is inconsistent; the error names the field. An effect that acts on no reading is a notice of the campaign.
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<Simulated, Error> {
    let mut plan = Plan::new(scenario)?;
    plan.set_nests(seed);
    let (steps, visits) = schedule(scenario, &plan);
    let once = DrawnOnce {
        systematic: Systematic::draw(&plan.systematic, seed),
        expansions: Expansions::draw(scenario, &plan.expansions, seed),
    };
    let mut acts = vec![false; plan.effects.len()];
    let mut lengths = measure(scenario, &plan, &once, (&steps, visits), seed, &mut acts);
    let notices = without_effect(&plan.effects, &acts);
    lengths.logged = temperature::logged(scenario, &lengths.readings, seed);
    let truth = Truth::new(scenario, &plan, &once.systematic, seed);
    Ok(Simulated {
        campaign: Campaign {
            notices,
            ..campaign(scenario, plan, steps, lengths, seed)
        },
        truth,
    })
}

/// A notice for each effect that has a size and acts on no reading.
fn without_effect(effects: &[ResolvedEffect], acts: &[bool]) -> Vec<String> {
    let effects = effects.iter().zip(acts).enumerate();
    let idle = effects.filter(|(_, (effect, acts))| {
        !**acts && effect.parameters.iter().any(|value| *value != 0.0)
    });
    let said = idle.map(|(number, (ResolvedEffect { effect, .. }, _))| {
        format!(
            "effects[{number}], `{}`, changes no length: nothing is measured when, or of what, it acts; correct its time or its \
             subject, or leave it out",
            effect.id
        )
    });
    said.collect()
}

/// What is the same in all readings.
struct DrawnOnce<'a> {
    systematic: Systematic,
    expansions: Expansions<'a>,
}

/// Reads every length at every visit; `acts` is set for the effects that do something.
fn measure(
    scenario: &Scenario,
    plan: &Plan,
    once: &DrawnOnce<'_>,
    (steps, visits): (&[Step], Vec<Visit<'_>>),
    seed: u64,
    acts: &mut [bool],
) -> Lengths {
    let mut lengths = Lengths::default();
    let progress = Progress::new(&visits);
    let temperatures = true_histories(scenario, &progress.campaign_s);
    for (stop_number, visit) in (0_u64..).zip(visits) {
        let mut deviates = Deviates::of_stop(seed, stop_number);
        let stop = StopCircumstances {
            plan,
            visit: &visit,
            positions: &steps[visit.step].positions,
            progress: &progress,
            temperatures: &temperatures,
        };
        let measured_mm = measure_stop(scenario, once, &stop, &mut deviates, acts);

        let first = lengths.readings.len();
        let readings = visit.targets.iter().zip(&visit.times_s);
        for ((&target, &time_s), length_mm) in readings.zip(measured_mm) {
            lengths.readings.push(LengthReading {
                time_s,
                target,
                length_mm,
                // Line 1 of the file is its header.
                line: lengths.readings.len() + 2,
            });
        }
        lengths.stops.push(Stop {
            station: visit.station,
            repeat: visit.repeat,
            step: visit.step,
            direction: visit.direction,
            readings: first..lengths.readings.len(),
        });
    }
    lengths
}

/// The lengths of one stop in the order of the run's targets, mm.
fn measure_stop(
    scenario: &Scenario,
    once: &DrawnOnce<'_>,
    stop: &StopCircumstances<'_>,
    deviates: &mut Deviates,
    acts: &mut [bool],
) -> Vec<f64> {
    let (plan, visit) = (stop.plan, stop.visit);
    let errors = Sweeping {
        axes: &plan.errors,
        axis: visit.run.map_or(0, |run| run.axis),
        direction: visit.direction,
    };
    let station = &scenario.stations[visit.station];
    let station_mm = Point3::from(station.position_mm);
    // The machine does not return to what stands on its bed.
    let returns_mm = visit.run.map_or(0.0, |_| plan.noise.repeatability_mm());
    let deviation_mm = deviates.normal_vector() * returns_mm;
    let readings = visit.targets.iter().zip(&visit.times_s);
    let points = readings.map(|(&target, &time_s)| {
        let (carrier, home_mm) = (plan.targets[target].carrier, plan.homes_mm[target]);
        let reached = once.expansions.reached(stop.positions, time_s);
        let p = plan.machine.position(&errors, carrier, &reached, home_mm);
        p + deviation_mm
    });
    let points: Vec<Point3<f64>> = points.collect();
    let displaced = stop.displaced(station_mm, &points, acts);
    let readings = visit.targets.iter().zip(&points).zip(displaced);
    let lengths = readings.map(|((&target, p), by)| {
        let beam = (p + by.point_mm) - (station_mm + by.station_mm);
        let distance_mm = beam.norm();
        let noise_mm = deviates.normal() * plan.noise.length_sigma_mm(distance_mm);
        let systematic_mm = once.systematic.length_mm(target, distance_mm);
        let length_mm =
            distance_mm - station.dead_path_mm + by.length_mm + noise_mm + systematic_mm;
        if scenario.noise.exact {
            length_mm
        } else {
            (length_mm * LENGTHS_PER_MM).round() / LENGTHS_PER_MM
        }
    });
    lengths.collect()
}

fn campaign(
    scenario: &Scenario,
    plan: Plan,
    steps: Vec<Step>,
    lengths: Lengths,
    seed: u64,
) -> Campaign {
    let dead_paths = known_dead_paths(scenario, seed);
    let stations = scenario.stations.iter().zip(dead_paths);
    Campaign {
        name: scenario.name.clone(),
        date: None,
        operator: None,
        machine_name: scenario.machine.name.clone(),
        instrument: scenario.instrument.clone(),
        known_lengths: plan.known_lengths(seed),
        targets: plan.targets,
        stations: stations
            .map(|(s, known)| declared_station(s, known))
            .collect(),
        runs: plan
            .runs
            .into_iter()
            .map(|run| Run {
                name: run.name,
                axis: run.axis,
            })
            .collect(),
        expansions: plan.expansions,
        machine: plan.machine,
        steps,
        lengths: Some(lengths),
        points: None,
        verification: Vec::new(),
        point_checks: Vec::new(),
        notices: Vec::new(),
    }
}

/// The station as the campaign file declares it.
fn declared_station(station: &StationSpec, dead_path: Option<KnownDeadPath>) -> Station {
    let paced = |c: f64| (c / PACE_MM).round() * PACE_MM;
    Station {
        name: station.name.clone(),
        approx_mm: station
            .declare_approx
            .then(|| Point3::from(station.position_mm.map(paced))),
        dead_path,
    }
}
