//! Blind trials: machines with smooth curves, some with an effect, through simulation and calibration.
//!
//! The study with 25 machines for each effect: right name and place in 24 (`cyclic_error`, 1.5 to 3 µm or
//! arcsec), 25 (all others); nothing wrong in any. True value within
//! 1.96 u: 72 of 72, 24 of 25 (`scale_error`, 25 to 60 ppm), 21 of 25 (`guideway_bow`; 19 without what the other guideways
//! show), 44, 47, 49 of 50 (angle about the axis, one, two, more waves), 92 and 96 of 100 (wobble, runout).

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_diagnose::{Cause, Diagnosis, Settings, diagnose};
use trueaxis_effects::Level;
use trueaxis_simulate::{Scenario, Term, simulate};

use crate::iso_run::table_of_stops;
use crate::machines::{Hidden, add, generator, linear_machine, machine_with, rotary_machine, sine};
use crate::{found, report};

/// What simulated lengths, or else the curves of their calibration, show.
fn diagnosed(scenario: &Scenario, seed: u64) -> Diagnosis {
    let campaign = simulate(scenario, seed).unwrap().campaign;
    diagnose(&campaign, &Settings::default()).unwrap()
}

/// What is named in the curves.
fn named(diagnosis: &Diagnosis) -> Vec<&Cause> {
    let all = diagnosis.causes.iter();
    all.filter(|cause| cause.level == Level::Components)
        .collect()
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
            .rival_effects()
            .map(|r| r.effect.id)
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
const SCALE_SEED: u64 = 7000;

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
    let diagnosis = diagnosed(&scenario, seed);
    counts.trials += 1;
    let mut found = false;
    for cause in named(&diagnosis) {
        let rival = cause.rival_effects().any(|r| r.effect.id == effect);
        if !found && is(cause, effect, &hidden, &scenario) {
            found = true;
            counts.right += u32::from(!rival);
            compare(cause, &hidden, counts, &mut |note| {
                notes.push(format!("{effect} {seed} {note}"));
            });
        } else if rival && !found {
            found = true;
            counts.among_rivals += 1;
        } else {
            counts.others += 1;
            let Hidden {
                component, values, ..
            } = &hidden;
            let shown = show(cause);
            notes.push(format!(
                "{effect} {seed} hidden {component:?} {values:?}: {shown}"
            ));
        }
    }
    if !found {
        counts.missed += 1;
        let Hidden {
            axis,
            component,
            values,
        } = &hidden;
        notes.push(format!(
            "{effect} {seed} missed {axis} {component:?} {values:?}"
        ));
    }
}

/// Whether a cause has the name, the place and the number of waves of what was hidden.
fn is(cause: &Cause, effect: &str, hidden: &Hidden, scenario: &Scenario) -> bool {
    let subject = &cause.effect.subject;
    let axis = subject.axis.map(|axis| &*scenario.machine.axes[axis].name);
    let component = subject.component.zip(axis).map(|(c, axis)| c.name(axis));
    let waves = hidden.values.iter().find(|value| value.0 == "waves");
    axis == Some(hidden.axis)
        && component == hidden.component
        && cause.effect.effect.id == effect
        && waves.is_none_or(|waves| (cause.effect.shape - waves.1).abs() < 1e-9)
}

/// Counts the true values inside 1.96 u.
fn compare(cause: &Cause, hidden: &Hidden, counts: &mut Counts, note: &mut impl FnMut(String)) {
    for (name, truth) in hidden.values.iter().filter(|value| value.0 != "waves") {
        let found = cause.parameters.iter().find(|p| p.name == *name).unwrap();
        let mut apart = found.value - truth;
        if *name == "phase" {
            apart = (apart + 180.0).rem_euclid(360.0) - 180.0;
        }
        counts.values += 1;
        if apart.abs() <= 1.96 * found.u {
            counts.covered += 1;
        } else {
            let (value, u) = (found.value, found.u);
            note(format!("{name}: {truth:.3} found {value:.3} ({u:.3})"));
        }
    }
}

/// One machine with an effect of each kind of curve: a regression with fixed seeds, the study gives the
/// rates.
#[test]
fn hidden_effects_are_named() {
    for effect in ["cyclic_error", "guideway_bow", "worm_gear", "axis_runout"] {
        let (mut counts, mut notes) = (Counts::default(), Vec::new());
        trial(effect, 1000, &mut counts, &mut notes);
        assert_eq!(
            counts.right + counts.among_rivals,
            1,
            "{effect} {counts:?} {notes:#?}"
        );
        assert_eq!(counts.others, 0, "{effect} {notes:#?}");
    }
}

/// The eigenvectors of a covariance, along which noise was drawn, are of either sign and in any order, as rounding has it: with
/// a picometre more or less in each length p-values differed by two in a thousand.
#[test]
fn last_digits_of_lengths_do_not_move_p_values() {
    let (scenario, _) = machine_with("cyclic_error", &mut generator(1000));
    let p_value = |by_mm: f64| {
        let mut campaign = simulate(&scenario, 1000).unwrap().campaign;
        let lengths = campaign.lengths.as_mut().unwrap();
        for (k, reading) in lengths.readings.iter_mut().enumerate() {
            reading.length_mm += if k % 2 == 0 { by_mm } else { -by_mm };
        }
        let diagnosis = diagnose(&campaign, &Settings::default()).unwrap();
        named(&diagnosis)[0].p_value
    };
    let (before, after) = (p_value(0.0), p_value(1e-9));
    assert!((after / before - 1.0).abs() < 1e-5, "{before} {after}");
}

/// Names in smooth curves of one linear and one rotary machine for each seed.
fn false_names(seeds: std::ops::Range<u64>) -> Vec<String> {
    let mut names = Vec::new();
    for seed in seeds {
        let machines: [fn(&mut ChaCha8Rng) -> Scenario; 2] = [linear_machine, rotary_machine];
        for machine in machines {
            let diagnosis = diagnosed(&machine(&mut generator(seed)), seed);
            let shown = named(&diagnosis).into_iter().map(show);
            names.extend(shown.map(|cause| format!("{seed} {cause}")));
        }
    }
    names
}

#[test]
fn smooth_curves_have_no_names() {
    let names = false_names(0..1);
    assert!(names.is_empty(), "{names:#?}");
}

/// In how many lines whose pitch errors are independent of each other, and add up to a walk, waves are seen.
fn waves_of_pitch_errors(seeds: std::ops::Range<u64>) -> usize {
    let has_waves = |seed: &u64| {
        let mut generator = generator(3000 + seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut generator) };
        let steps = (0..51).map(|_| 0.5 * normal());
        let walk = steps.scan(0.0, |sum, step| {
            *sum += step;
            Some(*sum)
        });
        let walk: Vec<f64> = walk.collect();
        let line = table_of_stops(3, 51, &mut |_, _, stop| walk[stop] + 0.3 * normal());
        let found = found(line);
        named(&found)
            .iter()
            .any(|cause| cause.effect.effect.id == "cyclic_error")
    };
    seeds.filter(has_waves).count()
}

/// No smooth process of the second order follows such a walk: by that alone waves were seen in 11 of 40 such lines, now in 1. At
/// that rate two of twelve have waves once in 28.
#[test]
fn pitch_errors_that_add_up_are_no_waves() {
    let count = waves_of_pitch_errors(0..12);
    assert!(count <= 1, "{count} of 12");
}

#[test]
#[ignore = "study: 40 diagnoses"]
fn pitch_errors_that_add_up_are_seldom_waves() {
    let count = waves_of_pitch_errors(0..40);
    report(&format!("waves in {count} of 40"));
    assert!(count <= 3, "{count} of 40");
}

/// Every axis of the campaign has equal steps, so each hides the periods that divide its step.
#[test]
fn periods_of_the_step_are_listed_as_not_observable() {
    let diagnosis = diagnosed(&linear_machine(&mut generator(0)), 0);
    let hidden = diagnosis.not_observable.iter();
    let hidden: Vec<_> = hidden
        .filter(|n| n.reason.contains("the step is"))
        .collect();
    let subjects: Vec<&str> = hidden.iter().map(|n| n.subject.as_str()).collect();
    assert_eq!(subjects, ["axis X", "axis Y", "axis Z"]);
    let reason = &hidden[0].reason;
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
        let mut settings = Settings::default();
        settings.calibration.poses.by_direction = true;
        let diagnosis = diagnose(&campaign, &settings).unwrap();
        for cause in named(&diagnosis) {
            let mut parameters = cause.parameters.iter();
            assert!(parameters.all(|p| p.value.is_finite() && p.u.is_finite()));
        }
    }
}

/// How steep a positioning is beside its bends is an assumption of the model. Where angles are steeper than that, a scale had the
/// uncertainty of a machine that is as expected.
#[test]
fn a_scale_is_less_certain_where_angles_are_steep() {
    let u_of_scale = |steep_arcsec: f64| {
        let mut scenario = linear_machine(&mut generator(4));
        let slope = |size: f64| Term::Polynomial {
            coefficients: vec![0.0, size],
        };
        add(&mut scenario, "X", "EXX", slope(60e-3 * 220.0));
        for (axis, angles) in [
            ("X", ["EBX", "ECX"]),
            ("Y", ["EAY", "ECY"]),
            ("Z", ["EAZ", "EBZ"]),
        ] {
            for angle in angles {
                add(&mut scenario, axis, angle, slope(steep_arcsec));
            }
        }
        let diagnosis = diagnosed(&scenario, 4);
        let causes = named(&diagnosis);
        assert_eq!(causes.len(), 1, "{causes:?}");
        assert_eq!(causes[0].effect.effect.id, "scale_error");
        causes[0].parameters[0].u
    };
    assert!(u_of_scale(12.0) > 1.5 * u_of_scale(0.0));
}

/// A scale with a cyclic error on one curve.
#[test]
fn two_effects_are_both_found() {
    let mut scenario = linear_machine(&mut generator(3));
    add(&mut scenario, "X", "EXX", sine(2.0, 70.0, 40.0, true));
    let coefficients = vec![0.0, 60e-3 * 220.0];
    add(&mut scenario, "X", "EXX", Term::Polynomial { coefficients });
    let diagnosis = diagnosed(&scenario, 3);
    let causes = named(&diagnosis).into_iter();
    let mut names: Vec<&str> = causes.map(|c| c.effect.effect.id).collect();
    names.sort_unstable();
    assert_eq!(names, ["cyclic_error", "scale_error"]);
}

/// Every second of 111 positions 4 mm apart shows a wave of 9.1 mm as one of 66 mm. The normal error of its period exceeds four standard
/// uncertainties with 6e-5; the seed is fixed.
#[test]
fn a_calibration_with_many_positions_shows_short_waves() {
    let mut scenario = linear_machine(&mut generator(7));
    scenario.repeats = 1;
    scenario.runs[0].sweep.as_mut().unwrap().step = 4.0;
    add(&mut scenario, "X", "EXX", sine(3.0, 9.1, 25.0, true));
    let diagnosis = diagnosed(&scenario, 7);
    let [cause] = named(&diagnosis)[..] else {
        panic!("{:?}", named(&diagnosis));
    };
    assert_eq!(cause.effect.effect.id, "cyclic_error");
    let period = cause.parameters.iter().find(|p| p.name == "period");
    let period = period.unwrap();
    let error = (period.value - 9.1).abs();
    assert!(period.u > 0.0 && error < 4.0 * period.u, "{period:?}");
}

/// At most 1 % of the machines; more than 2 of 40 come with a probability of 7e-3 at that rate.
#[test]
#[ignore = "study: 40 diagnoses"]
fn smooth_curves_hardly_ever_have_names() {
    let names = false_names(CLEAN_SEED..CLEAN_SEED + 20);
    report(&format!(
        "{} names in 20 linear and 20 rotary machines: {names:#?}",
        names.len()
    ));
    assert!(names.len() <= 2, "{names:#?}");
}

/// The counts at the top with 25 machines for each effect: 24, 20 and 25 of 25 right. For a true rate of
/// 96 % fewer than 20 come with a probability of 4e-4; nothing wrong may be named.
#[test]
#[ignore = "study: 200 diagnoses"]
fn hidden_effects_are_named_in_eight_of_ten() {
    for effect in EFFECTS {
        let (mut counts, mut notes) = (Counts::default(), Vec::new());
        for seed in HIDDEN_SEED..HIDDEN_SEED + 25 {
            trial(effect, seed, &mut counts, &mut notes);
        }
        report(&format!(
            "{effect}: {counts:?}\n    {}",
            notes.join("\n    ")
        ));
        assert!(counts.right >= 20, "{effect}: {counts:?}");
        assert_eq!(counts.others, 0, "{effect}: {counts:?}");
        // Intervals of 95 % within three standard errors.
        let coverage = f64::from(counts.covered) / f64::from(counts.values);
        let three = 3.0 * (0.95 * 0.05 / f64::from(counts.values)).sqrt();
        assert!(coverage > 0.95 - three, "{effect}: {counts:?}");
    }
}

/// Of machines that nothing was tried on. A coverage of 95 % and 250 machines, of which seven in ten show their scale, are within
/// three standard errors of 95 % with a probability of 99.7 %.
#[test]
#[ignore = "study: 250 diagnoses"]
fn true_scales_are_inside_their_intervals() {
    let (mut counts, mut notes) = (Counts::default(), Vec::new());
    for seed in SCALE_SEED..SCALE_SEED + 250 {
        trial("scale_error", seed, &mut counts, &mut notes);
    }
    report(&format!("{counts:?}\n    {}", notes.join("\n    ")));
    let inside = f64::from(counts.covered) / f64::from(counts.values);
    let three = 3.0 * (0.95 * 0.05 / f64::from(counts.values)).sqrt();
    assert!((inside - 0.95).abs() < three, "{counts:?}");
}
