//! Blind trials: machines with smooth curves, some with an effect, through simulation and calibration.
//!
//! The study with 25 machines for each effect: right name and place in 24 (`cyclic_error`, 1.5 to 3 µm or
//! arcsec), 20 (`scale_error`, 25 to 60 ppm), 25 (all others); nothing wrong in any. True value within
//! 1.96 u: 72 of 72, 19 of 20, 18 of 25 (`guideway_bow`, before the Birge ratio), 46, 47, 48 of 50 (angle
//! about the axis, one, two, more waves), 94 and 96 of 100 (wobble, runout).

mod machines;

use std::time::{Duration, Instant};

use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, Term, simulate};

use super::{ComponentsOutcome, diagnose_components};
use crate::diagnosis::Cause;
use machines::{add, generator, linear_machine, machine_with, rotary_machine, sine};

fn outcome(scenario: &Scenario, seed: u64) -> ComponentsOutcome {
    timed_outcome(scenario, seed).0
}

/// With the time that the diagnosis took, without simulation and calibration.
fn timed_outcome(scenario: &Scenario, seed: u64) -> (ComponentsOutcome, Duration) {
    let campaign = simulate(scenario, seed).unwrap().campaign;
    let settings = Settings {
        covariance: true,
        ..Settings::default()
    };
    let calibration = calibrate(&campaign, &settings).unwrap();
    let start = Instant::now();
    let outcome = diagnose_components(&calibration, &campaign.machine);
    (outcome, start.elapsed())
}

fn value(cause: &Cause, name: &str) -> (f64, f64) {
    let found = cause.parameters.iter().find(|p| p.name == name);
    found.map(|p| (p.value, p.u)).unwrap()
}

fn show(cause: &Cause) -> String {
    let parameters = cause.parameters.iter();
    let parameters: Vec<String> = parameters
        .map(|p| format!("{}={:.3}({:.3})", p.name, p.value, p.u))
        .collect();
    format!(
        "{} {:?} {:?} p={:.1e} share={:.2} bic={:.0} {} rivals={:?}",
        cause.effect.effect.id,
        cause.effect.subject.axis,
        cause.effect.subject.component,
        cause.p_value,
        cause.share_of_curve.unwrap_or(0.0),
        cause.delta_bic,
        parameters.join(" "),
        cause
            .rivals
            .iter()
            .map(|r| r.effect.effect.id)
            .collect::<Vec<_>>()
    )
}

const EFFECTS: [&str; 8] = [
    "cyclic_error",
    "scale_error",
    "guideway_bow",
    "encoder_eccentricity",
    "encoder_ellipticity",
    "worm_gear",
    "axis_wobble",
    "axis_runout",
];

/// Seeds of the studies: machines that nothing was tried on before.
const HIDDEN_SEED: u64 = 5000;
const CLEAN_SEED: u64 = 2000;

/// Counts of one effect over many machines.
#[derive(Debug, Default)]
struct Counts {
    trials: u32,
    right: u32,
    among_rivals: u32,
    missed: u32,
    /// Causes that are not what was hidden.
    others: u32,
    covered: u32,
    values: u32,
}

fn trial(effect: &'static str, seed: u64, counts: &mut Counts, notes: &mut Vec<String>) {
    let (scenario, hidden) = machine_with(effect, &mut generator(seed));
    let names: Vec<&str> = scenario
        .machine
        .axes
        .iter()
        .map(|a| a.name.as_str())
        .collect();
    let outcome = outcome(&scenario, seed);
    counts.trials += 1;
    let mut found = false;
    for cause in &outcome.causes {
        let axis = cause.effect.subject.axis.map(|axis| names[axis]);
        let component = cause.effect.subject.component;
        let component = component.zip(axis).map(|(c, axis)| c.name(axis));
        let place = axis == Some(hidden.axis) && component == hidden.component;
        let mut same_name = cause.effect.effect.id == effect;
        for (name, value) in &hidden.values {
            if *name == "waves" && same_name {
                same_name = (cause.effect.shape - value).abs() < 1e-9;
            }
        }
        let rival = cause.rivals.iter().any(|r| r.effect.effect.id == effect);
        if place && same_name && !found {
            found = true;
            counts.right += u32::from(!rival);
            for (name, truth) in hidden.values.iter().filter(|value| value.0 != "waves") {
                let (estimate, u) = value(cause, name);
                let mut apart = estimate - truth;
                if *name == "phase" {
                    apart = (apart + 180.0).rem_euclid(360.0) - 180.0;
                }
                counts.values += 1;
                if apart.abs() <= 1.96 * u {
                    counts.covered += 1;
                } else {
                    notes.push(format!(
                        "{effect} {seed} {name}: {truth:.3} found {estimate:.3} ({u:.3})"
                    ));
                }
            }
        } else if rival && !found {
            found = true;
            counts.among_rivals += 1;
        } else {
            counts.others += 1;
            notes.push(format!(
                "{effect} {seed} hidden {:?} {:?}: {}",
                hidden.component,
                hidden.values,
                show(cause)
            ));
        }
    }
    if !found {
        counts.missed += 1;
        notes.push(format!(
            "{effect} {seed} missed {} {:?} {:?}",
            hidden.axis, hidden.component, hidden.values
        ));
    }
}

/// The same with fixed seeds and few machines: a regression, not a statistic. The study gives the rates.
#[test]
fn hidden_effects_are_named() {
    for effect in EFFECTS {
        let (mut counts, mut notes) = (Counts::default(), Vec::new());
        for seed in 0..2 {
            trial(effect, 1000 + seed, &mut counts, &mut notes);
        }
        assert!(
            counts.right + counts.among_rivals >= 1,
            "{effect} {counts:?} {notes:#?}"
        );
        assert_eq!(counts.others, 0, "{effect} {notes:#?}");
    }
}

#[test]
fn smooth_curves_have_no_names() {
    for seed in 0..3 {
        for scenario in [
            linear_machine(&mut generator(seed)),
            rotary_machine(&mut generator(seed)),
        ] {
            let outcome = outcome(&scenario, seed);
            let shown: Vec<String> = outcome.causes.iter().map(show).collect();
            assert!(shown.is_empty(), "{seed} {shown:#?}");
        }
    }
}

/// Every axis of the campaign has equal steps, so each hides the periods that divide its step.
#[test]
fn periods_of_the_step_are_listed_as_not_observable() {
    let outcome = outcome(&linear_machine(&mut generator(0)), 0);
    let hidden: Vec<&str> = outcome
        .not_observable
        .iter()
        .map(|n| n.subject.as_str())
        .collect();
    assert_eq!(hidden, ["axis X", "axis Y", "axis Z"]);
    let reason = &outcome.not_observable[0].reason;
    assert!(
        reason.contains("the step is 20 mm") && reason.contains("20, 10, 6.667, 5 mm"),
        "{reason}"
    );
}

/// Five axes with curves for both sides of approach, and a machine without errors measured without noise.
#[test]
fn any_calibration_is_judged() {
    let five = include_str!("../../../../campaigns/five-axis/scenario.json");
    let by_direction = Scenario::from_json(five).unwrap();
    let mut exact = linear_machine(&mut generator(0));
    exact.errors.clear();
    exact.noise.length_sigma_um = Some(0.0);
    exact.noise.repeatability_um = Some(0.0);
    for scenario in [by_direction, exact] {
        let campaign = simulate(&scenario, 1).unwrap().campaign;
        let settings = Settings {
            covariance: true,
            by_direction: true,
            ..Settings::default()
        };
        let calibration = calibrate(&campaign, &settings).unwrap();
        let outcome = diagnose_components(&calibration, &campaign.machine);
        assert!(outcome.notices.is_empty(), "{:?}", outcome.notices);
        for cause in &outcome.causes {
            assert!(
                cause
                    .parameters
                    .iter()
                    .all(|p| p.value.is_finite() && p.u.is_finite())
            );
        }
    }
}

/// A scale with a cyclic error on one curve.
#[test]
fn two_effects_are_both_found() {
    let mut scenario = linear_machine(&mut generator(3));
    add(&mut scenario, "X", "EXX", sine(2.0, 70.0, 40.0, true));
    let coefficients = vec![0.0, 60e-3 * 220.0];
    add(&mut scenario, "X", "EXX", Term::Polynomial { coefficients });
    let outcome = outcome(&scenario, 3);
    let mut names: Vec<&str> = outcome.causes.iter().map(|c| c.effect.effect.id).collect();
    names.sort_unstable();
    assert_eq!(names, ["cyclic_error", "scale_error"]);
}

#[test]
#[ignore = "a study of minutes; TRIALS machines of each kind"]
#[expect(clippy::print_stderr, reason = "the study prints its counts")]
fn clean_study() {
    let trials: u64 = std::env::var("TRIALS").map_or(20, |s| s.parse().unwrap());
    let (mut linear, mut rotary) = (0, 0);
    let mut spent = Duration::ZERO;
    for seed in CLEAN_SEED..CLEAN_SEED + trials {
        let (o, time) = timed_outcome(&linear_machine(&mut generator(seed)), seed);
        spent += time;
        for cause in &o.causes {
            eprintln!("linear {seed} {}", show(cause));
        }
        linear += u32::from(!o.causes.is_empty());
        let (o, time) = timed_outcome(&rotary_machine(&mut generator(seed)), seed);
        spent += time;
        for cause in &o.causes {
            eprintln!("rotary {seed} {}", show(cause));
        }
        rotary += u32::from(!o.causes.is_empty());
    }
    eprintln!("clean: {linear} linear, {rotary} rotary false of {trials}; {spent:?} for all");
}

#[test]
#[ignore = "a study of minutes; TRIALS machines of each kind"]
#[expect(clippy::print_stderr, reason = "the study prints its counts")]
fn hidden_study() {
    let trials: u64 = std::env::var("TRIALS").map_or(10, |s| s.parse().unwrap());
    for effect in EFFECTS {
        let (mut counts, mut notes) = (Counts::default(), Vec::new());
        for seed in 0..trials {
            trial(effect, HIDDEN_SEED + seed, &mut counts, &mut notes);
        }
        eprintln!("{effect}: {counts:?}");
        for note in notes {
            eprintln!("    {note}");
        }
    }
}
