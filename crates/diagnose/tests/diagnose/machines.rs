//! Machines with random smooth curves, and effects hidden in them.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_simulate::{Scenario, Term};

const FXYZ: &str = include_str!("../../../../campaigns/fxyz/scenario.json");
const ROTARY: &str = include_str!("../../../../campaigns/rotary-stage/scenario.json");

pub(crate) fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

pub(crate) fn normal(generator: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(generator)
}

/// The three-axis machine with random smooth curves: polynomials of the fifth degree, 1 µm and
/// 1 arcsec for each coefficient, falling with its order.
pub(crate) fn linear_machine(generator: &mut ChaCha8Rng) -> Scenario {
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
pub(crate) fn rotary_machine(generator: &mut ChaCha8Rng) -> Scenario {
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

pub(crate) fn add(scenario: &mut Scenario, axis: &str, component: &str, term: Term) {
    let errors = scenario.errors.entry(axis.to_owned()).or_default();
    errors
        .components
        .entry(component.to_owned())
        .or_default()
        .push(term);
}

/// A machine with an effect.
pub(crate) fn machine_with(effect: &'static str, generator: &mut ChaCha8Rng) -> (Scenario, Hidden) {
    let linear = ["cyclic_error", "scale_error", "guideway_bow"].contains(&effect);
    let mut scenario = if linear {
        linear_machine(generator)
    } else {
        rotary_machine(generator)
    };
    let hidden = hide(effect, &mut scenario, generator);
    (scenario, hidden)
}

/// What was hidden in a machine.
pub(crate) struct Hidden {
    /// Name of the axis.
    pub(crate) axis: &'static str,
    /// Name of the component, where the subject has one.
    pub(crate) component: Option<String>,
    /// Names and true values, as the diagnosis should find them.
    pub(crate) values: Vec<(&'static str, f64)>,
}

pub(crate) fn between(generator: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * generator.random::<f64>()
}

pub(crate) fn sine(amplitude: f64, period: f64, phase_deg: f64, linear: bool) -> Term {
    Term::Sine {
        amplitude,
        period_mm: linear.then_some(period),
        period_deg: (!linear).then_some(period),
        phase_deg,
    }
}

/// Hides the effect in a random place, with a random size.
pub(crate) fn hide(
    effect: &'static str,
    scenario: &mut Scenario,
    generator: &mut ChaCha8Rng,
) -> Hidden {
    let axis = ["X", "Y", "Z"][generator.random_range(0..3)];
    let travel = if axis == "X" { 440.0 } else { 400.0 };
    let phase = between(generator, -180.0, 180.0);
    let sign = if generator.random::<bool>() {
        1.0
    } else {
        -1.0
    };
    let mut hidden = Hidden {
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
