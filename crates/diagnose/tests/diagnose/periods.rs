//! Periods and instants between those of the list that is tried, with their uncertainties.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};
use trueaxis_diagnose::{Cause, Diagnosis, Settings, Verdict, diagnose, diagnose_against};
use trueaxis_kinematics::{LocationError, MotionError};
use trueaxis_predict::{CalibratedMachine, FactoredCovariance, MeasuredAxis, Node};

use crate::iso_run::TARGET_MM;
use crate::machines::normal;
use crate::{campaign, generator, three_axes};

const SIGMA_UM: f64 = 0.3;
const STEP_MM: f64 = 10.0;
const STEPS: u32 = 40;
const EVERY_S: f64 = 8.0;

/// A line with five cycles there and back; `form` of time and position is added to the noise.
fn line(generator: &mut ChaCha8Rng, form: impl Fn(f64, f64) -> f64) -> Verification {
    let mut readings = Vec::new();
    for cycle in 1..=5 {
        for direction in [Direction::Forward, Direction::Backward] {
            for i in 0..=STEPS {
                let step = if direction == Direction::Forward {
                    i
                } else {
                    STEPS - i
                };
                let time_s = EVERY_S * readings.len() as f64;
                let x_mm = STEP_MM * f64::from(step);
                readings.push(VerificationReading {
                    time_s: Some(time_s),
                    cycle,
                    direction,
                    positions: vec![x_mm, 0.0, 0.0],
                    value_um: form(time_s, x_mm) + SIGMA_UM * normal(generator),
                    line: readings.len() + 2,
                });
            }
        }
    }
    Verification {
        name: "X".into(),
        kind: VerificationKind::Positioning {
            axis: 0,
            target_mm: TARGET_MM.into(),
        },
        u_um: None,
        u_ppm: None,
        readings,
    }
}

/// A machine without errors, known exactly.
fn zero() -> CalibratedMachine {
    let travel = f64::from(STEPS) * STEP_MM;
    let node = |position| Node {
        position,
        direction: None,
    };
    let axis = MeasuredAxis {
        axis: 0,
        nodes: [0.0, travel].map(node).to_vec(),
        errors: vec![MotionError::default(); 2],
        location: LocationError::default(),
        reported: Vec::new(),
    };
    CalibratedMachine::new(three_axes(), vec![axis], FactoredCovariance::zero(2, 12))
}

fn found(line: Verification) -> Diagnosis {
    diagnose_against(&campaign(vec![line]), &zero(), &Settings::default()).unwrap()
}

/// Each parameter of a cause with its truth: within four of its own standard uncertainties.
fn assert_near(cause: &Cause, truth: &[(&str, f64)]) {
    for (name, value) in truth {
        let found = cause.parameters.iter().find(|p| p.name == *name).unwrap();
        let error = (found.value - value).abs();
        assert!(
            found.u > 0.0 && error < 4.0 * found.u,
            "{truth:?}: {name} {} ± {}",
            found.value,
            found.u
        );
    }
}

/// Periods of the list and between them, from three steps to half the travel. Normal errors exceed four standard uncertainties
/// with 6.3e-5, so that one of 69 does with a probability of 0.4 %; the seeds are fixed.
fn assert_found(seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let mut generator = generator(seed, 41);
        let at_random = generator.random_range(30.0..200.0);
        let period = match seed {
            0 => 37.0,
            1 => 91.0,
            2 => 130.0,
            _ => at_random,
        };
        let phase = match seed {
            0..3 => 0.0,
            _ => generator.random_range(0.0..TAU),
        };
        let size_um = 3.0;
        let found = found(line(&mut generator, |_, x| {
            size_um * (TAU * x / period + phase).sin()
        }));
        assert_eq!(found.verdict, Verdict::Named, "period {period}");
        let [cause] = &found.causes[..] else {
            panic!("period {period}: {} causes", found.causes.len());
        };
        assert_eq!(cause.effect.effect.id, "cyclic_error", "period {period}");
        assert!(found.unexplained.is_none(), "period {period}");
        let truth = [
            ("period", period),
            ("sine", size_um * phase.cos()),
            ("cosine", size_um * phase.sin()),
        ];
        assert_near(cause, &truth);
    }
}

#[test]
fn a_period_between_two_of_the_list_is_found_with_its_uncertainty() {
    assert_found(0..6);
}

#[test]
#[ignore = "study: 23 diagnoses"]
fn periods_from_three_steps_to_half_the_travel_are_found() {
    assert_found(0..23);
}

/// Between two readings an instant may be anywhere.
#[test]
fn an_instant_lies_anywhere_between_two_readings() {
    let jump_s = 2100.0;
    let mut generator = generator(1, 42);
    let found = found(line(
        &mut generator,
        |t, _| if t > jump_s { 3.0 } else { 0.0 },
    ));
    let cause = &found.causes[0];
    let time = cause.parameters.last().unwrap();
    assert_eq!(time.name, "time");
    assert!(
        (time.u / (EVERY_S / 12_f64.sqrt()) - 1.0).abs() < 0.1,
        "{}",
        time.u
    );
    assert_near(cause, &[("time", jump_s)]);
}

/// Waves of two steps show one phase at the positions. Where the search went on to periods a hair longer, the other phase fitted
/// whatever is left, with hundreds of times the size.
#[test]
fn waves_of_two_steps_are_no_larger_than_what_is_read() {
    let size_um = 5.0;
    for seed in 0..4 {
        let mut generator = generator(seed, 43);
        let alternating = |_: f64, x: f64| size_um * (0.5 * TAU * x / STEP_MM).cos();
        let found = found(line(&mut generator, alternating));
        let [cause] = &found.causes[..] else {
            panic!("{} causes", found.causes.len());
        };
        assert_eq!(cause.effect.effect.id, "cyclic_error");
        let parameter = |name: &str| cause.parameters.iter().find(|p| p.name == name).unwrap();
        let (sine, cosine, period) = (parameter("sine"), parameter("cosine"), parameter("period"));
        assert!(
            sine.value.total_cmp(&0.0).is_eq() && sine.u.is_infinite(),
            "{sine:?}"
        );
        assert!((cosine.value - size_um).abs() < 4.0 * cosine.u);
        assert!((period.value - 2.0 * STEP_MM).abs() < 1e-6);
        // At most that.
        assert!(period.u.is_infinite());
    }
}

/// In the mean curve, too; its phase was that of the steps, with no uncertainty at all.
#[test]
fn waves_of_two_steps_have_no_phase() {
    let (size_um, phase) = (5.0, 1.0_f64);
    for (seed, from_home_mm) in [(0, 0.0), (1, 4.0)] {
        let mut generator = generator(seed, 46);
        let wave = |x: f64| size_um * (0.5 * TAU * x / STEP_MM + phase).sin();
        let mut line = line(&mut generator, |_, x| wave(x + from_home_mm));
        for reading in &mut line.readings {
            reading.positions[0] += from_home_mm;
        }
        let found = diagnose(&campaign(vec![line]), &Settings::default()).unwrap();
        let [cause] = &found.causes[..] else {
            panic!("{} causes", found.causes.len());
        };
        let names: Vec<&str> = cause.parameters.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["sine", "cosine", "amplitude", "period"]);
        let [sine, cosine, amplitude, _] = &cause.parameters[..] else {
            unreachable!("four names");
        };
        // What alternates at the steps is the wave's part there.
        let shown_um = wave(from_home_mm).abs();
        assert!((amplitude.value - shown_um).abs() < 0.2, "{amplitude:?}");
        assert!(amplitude.u.is_infinite() && sine.u.is_infinite());
        // At home the steps show all of the cosine, elsewhere a mixture of both.
        let is_node = seed == 0;
        assert_eq!(cosine.u.is_finite(), is_node);
        assert_eq!(sine.value.total_cmp(&0.0).is_eq(), is_node, "{sine:?}");
    }
}

/// With a clock a table may be sorted by position, or not at all.
#[test]
fn rows_with_a_clock_may_stand_in_any_order() {
    let mut generator = generator(2, 44);
    let as_measured = line(&mut generator, |t, _| if t > 2100.0 { 3.0 } else { 0.0 });
    let mut sorted = as_measured.clone();
    sorted
        .readings
        .sort_by(|a, b| a.positions[0].total_cmp(&b.positions[0]));
    let [first, second] = [as_measured, sorted].map(found);
    assert_eq!(first.causes.len(), 1);
    assert_eq!(first.causes[0].parameters, second.causes[0].parameters);
    assert_eq!(first.verdict, second.verdict);
}

/// What swings as often as the cycle is repeated is lost motion under another name. Where it stands beside lost motion that is
/// smaller at the stop after the turn, it took most of it, and left the wrong sign.
#[test]
fn lost_motion_is_no_swing_with_the_period_of_the_cycle() {
    let (size_um, of_first) = (-1.4, 0.4);
    for seed in 0..4 {
        let mut generator = generator(seed, 45);
        let mut readings = Vec::new();
        let mut time_s = 0.0;
        let mut mean_um = 0.0;
        for cycle in 1..=5 {
            for direction in [Direction::Forward, Direction::Backward] {
                for i in 0..9_u32 {
                    let sign = f64::from(direction.sign());
                    let part = if i == 0 { of_first } else { 1.0 };
                    let x_mm = -sign * (20.0 - 5.0 * f64::from(i));
                    let value_um = -0.5 * sign * size_um * part;
                    mean_um += -2.0 * sign * value_um / 90.0;
                    readings.push(VerificationReading {
                        time_s: Some(time_s),
                        cycle,
                        direction,
                        positions: vec![x_mm, 0.0, 0.0],
                        value_um: value_um + 0.01 * normal(&mut generator),
                        line: readings.len() + 2,
                    });
                    time_s += 28.5;
                }
                time_s -= 12.0;
            }
        }
        let line = Verification {
            readings,
            ..line(&mut generator, |_, _| 0.0)
        };
        let found = diagnose(&campaign(vec![line]), &Settings::default()).unwrap();
        let cause = &found.causes[0];
        assert!(cause.effect.effect.id.ends_with("backlash"));
        let mean = &cause.parameters[0];
        assert!(
            (mean.value - mean_um).abs() < 0.1,
            "{} for {mean_um}",
            mean.value
        );
    }
}

/// The share of a wave in its curve does not depend on how it lies to a slope.
#[test]
fn a_wave_has_one_share_at_any_phase() {
    for quarter in 0..4 {
        let mut random = generator(quarter, 64);
        let phase = 0.25 * TAU * quarter as f64;
        let form = |_, x: f64| 0.1 * x + 3.0 * (TAU * x / 50.0 + phase).sin();
        let found = diagnose(
            &campaign(vec![line(&mut random, form)]),
            &Settings::default(),
        );
        let found = found.unwrap();
        let mut waves = found.causes.iter();
        let wave = waves.find(|own| own.effect.effect.id == "cyclic_error");
        let share = wave.and_then(|own| own.share_of_curve).unwrap();
        assert!((share - 0.033).abs() < 0.004, "{quarter}: {share}");
    }
}
