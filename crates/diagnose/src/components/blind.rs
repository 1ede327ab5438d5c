//! Blind trials: machines with smooth curves, some with an effect, through simulation and calibration.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_simulate::{Scenario, Term, simulate};

use super::{ComponentsOutcome, diagnose_components};
use crate::diagnosis::Cause;

const FXYZ: &str = include_str!("../../../../campaigns/fxyz/scenario.json");
const ROTARY: &str = include_str!("../../../../campaigns/rotary-stage/scenario.json");

fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

fn normal(generator: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(generator)
}

/// The three-axis machine with random smooth curves: polynomials of the fifth degree, 1 µm and
/// 1 arcsec for each coefficient, falling with its order.
fn linear_machine(generator: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario::from_json(FXYZ).unwrap();
    for errors in scenario.errors.values_mut() {
        for terms in errors.components.values_mut() {
            let coefficients = (0..6_i32).map(|k| normal(generator) / f64::from(k.max(1)));
            *terms = vec![Term::Polynomial {
                coefficients: coefficients.collect(),
            }];
        }
    }
    scenario
}

/// The rotary stage with random smooth curves: all waves up to nine per turn with random phases and
/// amplitudes (Rayleigh) that fall as `1 / (n² + 1)`.
fn rotary_machine(generator: &mut ChaCha8Rng) -> Scenario {
    let mut scenario = Scenario::from_json(ROTARY).unwrap();
    for errors in scenario.errors.values_mut() {
        for terms in errors.components.values_mut() {
            *terms = (1..=9_i32)
                .map(|n| Term::Sine {
                    amplitude: normal(generator).hypot(normal(generator)) / f64::from(n * n + 1),
                    period_mm: None,
                    period_deg: Some(360.0 / f64::from(n)),
                    phase_deg: 360.0 * generator.random::<f64>(),
                })
                .collect();
        }
    }
    scenario
}

fn add(scenario: &mut Scenario, axis: &str, component: &str, term: Term) {
    let errors = scenario.errors.entry(axis.to_owned()).or_default();
    errors
        .components
        .entry(component.to_owned())
        .or_default()
        .push(term);
}

fn outcome(scenario: &Scenario, seed: u64) -> ComponentsOutcome {
    let campaign = simulate(scenario, seed).unwrap().campaign;
    let settings = Settings {
        covariance: true,
        ..Settings::default()
    };
    let calibration = calibrate(&campaign, &settings).unwrap();
    diagnose_components(&calibration, &campaign.machine)
}

fn value<'a>(cause: &'a Cause, name: &str) -> (f64, f64) {
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
        cause.effect.effect.id(),
        cause.effect.subject.axis,
        cause.effect.subject.component,
        cause.p_value,
        cause.share_of_curve.unwrap_or(0.0),
        cause.delta_bic,
        parameters.join(" "),
        cause
            .rivals
            .iter()
            .map(|r| r.effect.effect.id())
            .collect::<Vec<_>>()
    )
}

#[test]
#[ignore = "a study"]
#[expect(clippy::print_stderr, reason = "the study prints its counts")]
fn clean_study() {
    let trials: u64 = std::env::var("TRIALS").map_or(20, |s| s.parse().unwrap());
    let (mut linear, mut rotary) = (0, 0);
    for seed in 0..trials {
        let o = outcome(&linear_machine(&mut generator(seed)), seed);
        for cause in &o.causes {
            eprintln!("linear {seed} {}", show(cause));
        }
        linear += u32::from(!o.causes.is_empty());
        let o = outcome(&rotary_machine(&mut generator(seed)), seed);
        for cause in &o.causes {
            eprintln!("rotary {seed} {}", show(cause));
        }
        rotary += u32::from(!o.causes.is_empty());
    }
    eprintln!("clean: {linear} linear, {rotary} rotary false of {trials}");
}

/// What was hidden in a machine.
struct Hidden {
    effect: &'static str,
    axis: &'static str,
    component: Option<String>,
    /// Names and true values, as the diagnosis should find them.
    values: Vec<(&'static str, f64)>,
}

fn between(generator: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * generator.random::<f64>()
}

fn sine(amplitude: f64, period: f64, phase_deg: f64, linear: bool) -> Term {
    Term::Sine {
        amplitude,
        period_mm: linear.then_some(period),
        period_deg: (!linear).then_some(period),
        phase_deg,
    }
}

/// Hides the effect in a random place, with a random size.
fn hide(effect: &'static str, scenario: &mut Scenario, generator: &mut ChaCha8Rng) -> Hidden {
    let axis = ["X", "Y", "Z"][generator.random_range(0..3)];
    let travel = if axis == "X" { 440.0 } else { 400.0 };
    let phase = between(generator, -180.0, 180.0);
    let sign = if generator.random::<bool>() {
        1.0
    } else {
        -1.0
    };
    let mut hidden = Hidden {
        effect,
        axis,
        component: None,
        values: Vec::new(),
    };
    match effect {
        "cyclic_error" => {
            let letter = ["X", "Y", "Z", "A", "B", "C"][generator.random_range(0..6)];
            let component = format!("E{letter}{axis}");
            let amplitude = between(generator, 1.5, 3.0);
            let period = between(generator, 45.0, 150.0);
            add(
                scenario,
                axis,
                &component,
                sine(amplitude, period, phase, true),
            );
            hidden.values = vec![
                ("period", period),
                ("amplitude", amplitude),
                ("phase", phase),
            ];
            hidden.component = Some(component);
        }
        "scale_error" => {
            let ppm = sign * between(generator, 25.0, 60.0);
            let coefficients = vec![0.0, ppm * 1e-3 * travel / 2.0];
            let component = format!("E{axis}{axis}");
            add(
                scenario,
                axis,
                &component,
                Term::Polynomial { coefficients },
            );
            hidden.values = vec![("scale", ppm)];
        }
        "guideway_bow" => {
            // Straightness, angle and sign of the angle's slope.
            let pairs = match axis {
                "X" => [("EYX", "ECX", 1.0), ("EZX", "EBX", -1.0)],
                "Y" => [("EXY", "ECY", -1.0), ("EZY", "EAY", 1.0)],
                _ => [("EXZ", "EBZ", 1.0), ("EYZ", "EAZ", -1.0)],
            };
            let (straightness, angle, slope) = pairs[generator.random_range(0..2)];
            let sagitta = sign * between(generator, 4.0, 8.0);
            let bow = sagitta / (0.5e-3 * travel).powi(2);
            let coefficients = vec![0.0, 0.0, sagitta];
            add(
                scenario,
                axis,
                straightness,
                Term::Polynomial { coefficients },
            );
            let rise_arcsec = 2e-9 * bow * travel / trueaxis_kinematics::ARCSEC;
            let coefficients = vec![0.0, slope * rise_arcsec / 2.0];
            add(scenario, axis, angle, Term::Polynomial { coefficients });
            hidden.values = vec![("bow", bow)];
            hidden.component = Some(straightness.to_owned());
        }
        "encoder_eccentricity" | "encoder_ellipticity" | "worm_gear" => {
            let waves = match effect {
                "encoder_eccentricity" => 1.0,
                "encoder_ellipticity" => 2.0,
                _ => f64::from(generator.random_range(3..9_u8)),
            };
            let amplitude = between(generator, 6.0, 12.0) / waves;
            add(
                scenario,
                "C",
                "ECC",
                sine(amplitude, 360.0 / waves, phase, false),
            );
            hidden.axis = "C";
            hidden.values = vec![("amplitude", amplitude), ("phase", phase)];
            if effect == "worm_gear" {
                hidden.values.push(("waves", waves));
            }
        }
        _ => {
            let names = if effect == "axis_wobble" {
                ["EAC", "EBC"]
            } else {
                ["EXC", "EYC"]
            };
            let waves = f64::from(generator.random_range(2..8_u8));
            for name in names {
                let amplitude = between(generator, 3.0, 6.0) / waves.sqrt();
                let phase = between(generator, -180.0, 180.0);
                add(
                    scenario,
                    "C",
                    name,
                    sine(amplitude, 360.0 / waves, phase, false),
                );
                let (s, c) = phase.to_radians().sin_cos();
                let names = match name {
                    "EAC" => ["sine_a", "cosine_a"],
                    "EBC" => ["sine_b", "cosine_b"],
                    "EXC" => ["sine_x", "cosine_x"],
                    _ => ["sine_y", "cosine_y"],
                };
                hidden.values.push((names[0], amplitude * c));
                hidden.values.push((names[1], amplitude * s));
            }
            hidden.axis = "C";
            hidden.values.push(("waves", waves));
        }
    }
    hidden
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

fn machine_with(effect: &'static str, generator: &mut ChaCha8Rng) -> (Scenario, Hidden) {
    let linear = ["cyclic_error", "scale_error", "guideway_bow"].contains(&effect);
    let mut scenario = if linear {
        linear_machine(generator)
    } else {
        rotary_machine(generator)
    };
    let hidden = hide(effect, &mut scenario, generator);
    (scenario, hidden)
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
        let mut same_name = cause.effect.effect.id() == effect;
        for (name, value) in &hidden.values {
            if *name == "waves" && same_name {
                same_name = (cause.effect.shape - value).abs() < 1e-9;
            }
        }
        let rival = cause.rivals.iter().any(|r| r.effect.effect.id() == effect);
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

#[test]
#[ignore = "a study"]
#[expect(clippy::print_stderr, reason = "the study prints its counts")]
fn hidden_study() {
    let trials: u64 = std::env::var("TRIALS").map_or(10, |s| s.parse().unwrap());
    for effect in EFFECTS {
        let (mut counts, mut notes) = (Counts::default(), Vec::new());
        for seed in 0..trials {
            trial(effect, 1000 + seed, &mut counts, &mut notes);
        }
        eprintln!("{effect}: {counts:?}");
        for note in notes {
            eprintln!("    {note}");
        }
    }
}
