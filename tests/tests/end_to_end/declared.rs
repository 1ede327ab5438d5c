//! All that a campaign can declare at once, drawn anew for each: reflectors, scale, nests.

use std::ops::Range;

use trueaxis_calibrate::Method;
use trueaxis_diagnose::diagnose;
use trueaxis_simulate::{Scenario, TargetSpec, simulate};
use trueaxis_tests::estimators::{SCENARIOS, scatter, settings};

const REFLECTORS_UM: f64 = 2.0;
const SCALE_PPM: f64 = 2.0;
const NESTS_MM: f64 = 0.5;

fn declared(text: &str) -> Scenario {
    let mut scenario = Scenario::from_json(text).unwrap();
    scenario.instrument.reflector_sigma_um = Some(REFLECTORS_UM);
    scenario.instrument.scale_sigma_ppm = Some(SCALE_PPM);
    for target in &mut scenario.targets {
        target.position_sigma_mm = Some(NESTS_MM);
    }
    scenario
}

/// The three axes five times as large, with eight targets on the ram.
fn gantry() -> Scenario {
    const LARGER: f64 = 5.0;
    let mut scenario = declared(SCENARIOS[0].1);
    for axis in &mut scenario.machine.axes {
        axis.travel = axis.travel.map(|end| LARGER * end);
    }
    for run in &mut scenario.runs {
        if let Some(sweep) = &mut run.sweep {
            (sweep.stop, sweep.step) = (LARGER * sweep.stop, LARGER * sweep.step);
        }
    }
    for station in &mut scenario.stations {
        station.position_mm = station.position_mm.map(|x| LARGER * x);
    }
    let like = scenario.targets[0].clone();
    scenario.targets = (0..8)
        .map(|k| TargetSpec {
            name: format!("T{}", k + 1),
            position_mm: [
                500.0 + 400.0 * f64::from(k & 1),
                300.0 + 350.0 * f64::from(k >> 1 & 1) + 60.0 * f64::from(k & 1),
                200.0 + 500.0 * f64::from(k >> 2) + 40.0 * f64::from(k >> 1 & 1),
            ],
            mounting_error_mm: [0.0; 3],
            ..like.clone()
        })
        .collect();
    scenario
}

fn machines() -> Vec<(&'static str, Scenario)> {
    let shipped = SCENARIOS.iter();
    let mut all: Vec<_> = shipped
        .map(|(name, text)| (*name, declared(text)))
        .collect();
    all.push(("gantry", gantry()));
    all
}

/// Each kind of result scatters as stated and 95 % of the intervals hold the truth, within `times` standard errors that
/// follow from the scatter between the campaigns.
fn assert_is_as_stated(seeds: &Range<u64>, times: f64) {
    let mut off = Vec::new();
    for (name, scenario) in machines() {
        let settings = settings(&scenario, Method::Joint);
        let scatter = scatter(&scenario, &settings, seeds.clone()).unwrap();
        for kind in scatter.kinds() {
            let pooled = scatter.pooled(|d| d.kind == kind);
            println!("{name}, {kind}: {pooled}");
            if !pooled.is_as_stated(times) {
                off.push(format!("{name}, {kind}: {pooled}"));
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}

/// One of some 80 numbers is off by chance with a probability of 2e-3 (Student's, 29 degrees of freedom). With fewer campaigns
/// what is drawn once for each could hardly fail.
#[test]
fn what_is_declared_is_in_u() {
    assert_is_as_stated(&(0..30), 5.0);
}

/// One of some 80 numbers is off by chance with a probability of 20 %; the seeds are fixed.
#[test]
#[ignore = "study: 1200 calibrations"]
fn what_is_declared_is_in_u_in_300_campaigns() {
    assert_is_as_stated(&(1000..1300), 3.0);
}

/// Reflectors that differ are no slips, and none creeps: named in at most 1 % of 300 campaigns. (The five axes have lost
/// motion, which is named in all of them.)
#[test]
#[ignore = "study: 300 diagnoses"]
fn reflectors_that_differ_are_no_slips() {
    let mut slips = 0;
    for (name, scenario) in machines() {
        for seed in 0..75 {
            let campaign = simulate(&scenario, seed).unwrap().campaign;
            let settings = trueaxis_diagnose::Settings {
                explain_curves: false,
                ..Default::default()
            };
            let diagnosis = diagnose(&campaign, &settings).unwrap();
            let causes = diagnosis.causes.iter().map(|cause| cause.effect.effect.id);
            let causes: Vec<&str> = causes.filter(|id| *id != "backlash").collect();
            if !causes.is_empty() {
                println!(
                    "{name}, seed {seed}: {}: {causes:?}",
                    diagnosis.verdict.name()
                );
            }
            slips += usize::from(causes.iter().any(|id| id.starts_with("target_")));
        }
    }
    println!("{slips} slips or creeps in 300 campaigns");
    assert!(slips <= 3);
}
