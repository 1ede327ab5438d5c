//! Lines against a calibration that is itself uncertain.
//!
//! The machine has error curves; a calibration knows them from points with noise, so that its errors are
//! correlated along each axis as in real life.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Settings, calibrate};
use trueaxis_campaign::{
    Campaign, Direction, Instrument, PointReading, Points, Run, Step, Stop, Target, Verification,
    VerificationKind, VerificationReading,
};
use trueaxis_effects::Scene;
use trueaxis_kinematics::{
    ARCSEC, Axis, GeometricErrors, LocationError, MICROMETRE, Machine, MotionError,
};
use trueaxis_predict::CalibratedMachine;

use crate::Cause;
use crate::said::Entry;
use crate::verification::base::base_columns;
use crate::verification::comparison::Comparison;
use crate::verification::diagnose_verification;
use crate::verification::prediction_error::prediction_directions;
use crate::verification::problem::{Given, Problem};

const SIGMA_UM: f64 = 0.5;
/// Of one coordinate of a measured point.
const POINT_SIGMA_UM: f64 = 0.7;
const TARGET_MM: [f64; 3] = [100.0, 300.0, 200.0];

/// Cycles there and back along X, 21 positions each way.
const CYCLES: u32 = 5;
const STEP_MM: f64 = 20.0;

/// X carries Y carries Z.
fn three_axes() -> Machine {
    let axis = |name, direction| Axis::linear(name, direction, [0.0, 400.0]).unwrap();
    let axes = vec![
        axis("X", Vector3::x()),
        axis("Y", Vector3::y()),
        axis("Z", Vector3::z()),
    ];
    Machine::new(axes, vec![0, 1, 2], vec![]).unwrap()
}

/// A campaign of verifications only.
fn campaign(verification: Vec<Verification>) -> Campaign {
    Campaign {
        name: "verification".into(),
        date: None,
        operator: None,
        machine_name: "FXYZ".into(),
        machine: three_axes(),
        expansions: Vec::new(),
        instrument: Instrument::default(),
        targets: Vec::new(),
        stations: Vec::new(),
        known_lengths: Vec::new(),
        runs: Vec::new(),
        steps: Vec::new(),
        lengths: None,
        points: None,
        verification,
        point_checks: Vec::new(),
        notices: Vec::new(),
    }
}

fn scene() -> Scene {
    Scene {
        machine: three_axes(),
        stations: Vec::new(),
        targets: Vec::new(),
        moving: Vec::new(),
        temperatures: Vec::new(),
    }
}

/// Where X stands at the readings, each with its cycle and direction.
fn stands() -> Vec<(u32, Direction, f64)> {
    let mut stands = Vec::new();
    for cycle in 1..=CYCLES {
        let there = (0..21).map(|i| (cycle, Direction::Forward, STEP_MM * f64::from(i)));
        let back = (0..21).rev();
        let back = back.map(|i| (cycle, Direction::Backward, STEP_MM * f64::from(i)));
        stands.extend(there.chain(back));
    }
    stands
}

fn table(values_um: &[f64]) -> Verification {
    let rows = stands().into_iter().zip(values_um).enumerate();
    let readings = rows.map(
        |(row, ((cycle, direction, x_mm), &value_um))| VerificationReading {
            time_s: None,
            cycle,
            direction,
            positions: vec![x_mm, 0.0, 0.0],
            value_um,
            line: row + 2,
        },
    );
    Verification {
        name: "LI along X".into(),
        kind: VerificationKind::Positioning {
            axis: 0,
            target_mm: TARGET_MM.into(),
        },
        u_um: None,
        u_ppm: None,
        readings: readings.collect(),
    }
}

/// Error curves of every axis: a wave each, zero at home for position and angles.
struct Truth {
    waves: [[[f64; 3]; 6]; 3],
}

impl Truth {
    fn new(generator: &mut ChaCha8Rng) -> Self {
        let wave = |generator: &mut ChaCha8Rng| {
            [
                generator.random_range(-5.0..5.0),
                generator.random_range(0.3..1.5),
                generator.random_range(0.0..TAU),
            ]
        };
        Self {
            waves: std::array::from_fn(|_| std::array::from_fn(|_| wave(generator))),
        }
    }
}

impl GeometricErrors for Truth {
    fn location(&self, _: usize) -> LocationError {
        LocationError::default()
    }

    fn motion(&self, axis: usize, position: f64) -> MotionError {
        let value = |c: usize| {
            let [size, waves, phase] = self.waves[axis][c];
            let unit = if c < 3 { MICROMETRE } else { 0.5 * ARCSEC };
            let angle = TAU * waves * position / 400.0 + phase;
            unit * size * (angle.sin() - phase.sin())
        };
        MotionError::from_vector(&Vector6::from_fn(|c, _| value(c)))
    }
}

/// Points of three targets along the three axes.
fn points(machine: &Machine, truth: &Truth, generator: &mut ChaCha8Rng) -> Campaign {
    let homes = [
        [20.0, 450.0, 120.0],
        [160.0, 330.0, 320.0],
        [250.0, 600.0, 410.0],
    ];
    let mut all = campaign(Vec::new());
    all.targets = ["P", "Q", "K"]
        .iter()
        .zip(homes)
        .map(|(name, home)| Target {
            name: (*name).into(),
            home_mm: home.into(),
            carrier: Some(2),
            ..Target::default()
        })
        .collect();
    let (mut stops, mut readings) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        all.runs.push(Run {
            name: ["x", "y", "z"][axis].into(),
            axis,
        });
        for i in 0..21 {
            let mut positions = vec![0.0; 3];
            positions[axis] = 20.0 * f64::from(i);
            let step = all.steps.len();
            all.steps.push(Step {
                run: Some(axis),
                positions: positions.clone(),
            });
            let first = readings.len();
            for (target, home) in homes.iter().enumerate() {
                let mut at = machine.position(truth, 2, &positions, Point3::from(*home));
                for c in 0..3 {
                    let noise: f64 = StandardNormal.sample(generator);
                    at[c] += POINT_SIGMA_UM * MICROMETRE * noise;
                }
                readings.push(PointReading {
                    time_s: readings.len() as f64,
                    target,
                    position_mm: at,
                    sigma_um: Some(POINT_SIGMA_UM),
                    line: readings.len() + 2,
                });
            }
            stops.push(Stop {
                station: 0,
                repeat: 1,
                step,
                direction: Direction::Forward,
                readings: first..readings.len(),
            });
        }
    }
    all.points = Some(Points { stops, readings });
    all
}

/// A machine, its calibration, and the line that is measured on it.
struct Setting {
    calibration: CalibratedMachine,
    campaign: Campaign,
}

/// `form` of x is added to the readings with λ in the sight of the diagnosis' projection.
fn setting(seed: u64, lambda: f64, form: impl Fn(f64) -> f64) -> Setting {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(5);
    let machine = three_axes();
    let truth = Truth::new(&mut generator);
    let measured = points(&machine, &truth, &mut generator);
    let calibration = calibrate(&measured, &Settings::default()).unwrap();
    let calibration = calibration.calibrated_machine();
    let read = |x_mm: f64| {
        let actual = machine.position(&truth, 2, &[x_mm, 0.0, 0.0], TARGET_MM.into());
        (actual.x - TARGET_MM[0] - x_mm) / MICROMETRE
    };
    let bare: Vec<f64> = stands().iter().map(|stand| read(stand.2)).collect();
    let trace: Vec<f64> = stands().iter().map(|stand| form(stand.2)).collect();
    let visible = beyond_the_prediction(&calibration, &table(&trace));
    let visible = visible.iter().map(|x| x * x).sum::<f64>().sqrt();
    let size = if visible > 0.0 { lambda / visible } else { 0.0 };
    let values = bare.iter().zip(&trace).map(|(bare, x)| {
        let noise: f64 = StandardNormal.sample(&mut generator);
        // The interferometer's zero is anywhere.
        17.0 + bare + size * x + SIGMA_UM * noise
    });
    let values: Vec<f64> = values.collect();
    Setting {
        calibration,
        campaign: campaign(vec![table(&values)]),
    }
}

/// What the base model with the calibration's uncertainty leaves of a trace given as readings, in
/// standard deviations.
fn beyond_the_prediction(calibration: &CalibratedMachine, trace: &Verification) -> Vec<f64> {
    let machine = calibration.machine();
    let comparison = Comparison::new(machine, trace, &trueaxis_kinematics::Ideal);
    let directions = prediction_directions(&[&comparison], calibration, SIGMA_UM);
    let base = base_columns(&comparison, true);
    let given = Given {
        calibrated: true,
        sigma_um: SIGMA_UM,
        resolution_um: 0.0,
        hidden_um: 0.0,
        base: &base,
        prediction: &directions,
    };
    Problem::new(&comparison, &scene(), &given)
        .listed
        .base
        .residuals
}

fn outcome(setting: &Setting) -> Entry {
    let outcome = diagnose_verification(
        &setting.campaign,
        Some(&setting.calibration),
        &scene(),
        true,
    );
    outcome.entries.into_iter().next().unwrap()
}

fn assert_silent(of: u64, allowed: usize) {
    let alarms = (0..of).filter(|&seed| {
        let found = outcome(&setting(seed, 0.0, |_| 0.0));
        !found.causes.is_empty() || found.report.unexplained.is_some()
    });
    let alarms: Vec<u64> = alarms.collect();
    assert!(alarms.len() <= allowed, "seeds {alarms:?}");
}

/// Two families at 1 %; more than one of four alarms comes with a probability of 2e-3 at 2 %. The seeds are
/// fixed.
#[test]
fn a_calibration_within_its_uncertainty_raises_no_alarm() {
    assert_silent(4, 1);
}

/// 6 of 60 come with a probability of 2e-3 at a rate of 2 %.
#[test]
#[ignore = "study: 60 diagnoses"]
fn a_calibration_within_its_uncertainty_raises_few_alarms() {
    assert_silent(60, 5);
}

/// A trace over x.
type Form = fn(f64) -> f64;

/// Scale and cyclic error beyond the calibration: named, or among the rivals, in nine of ten at least.
fn assert_named(of: u64) {
    let cyclic: Form = |x| (TAU * x / 63.0 + 0.4).sin();
    let cases: [(&str, Form); 2] = [("scale_error", |x| x), ("cyclic_error", cyclic)];
    for lambda in [7.0, 20.0] {
        for (effect, form) in cases {
            let is_it = |found: &Entry| {
                let holds = |cause: &Cause| {
                    let rivals = cause.rivals.iter().map(|rival| &rival.effect);
                    let mut all = rivals.chain([&cause.effect]);
                    all.any(|e| e.effect.id == effect && e.subject.axis == Some(0))
                };
                !found.causes.is_empty() && found.causes.iter().all(holds)
            };
            let right = (0..of)
                .filter(|&seed| is_it(&outcome(&setting(seed, lambda, form))))
                .count() as u64;
            assert!(
                10 * right >= 9 * of,
                "λ {lambda}: {effect}: {right} of {of}"
            );
        }
    }
}

#[test]
fn each_effect_is_named() {
    assert_named(1);
}

/// For a true rate of 99 % fewer than 18 of 20 come with a probability of 1e-3 for each case.
#[test]
#[ignore = "study: 80 diagnoses"]
fn each_effect_is_named_in_nine_of_ten() {
    assert_named(20);
}
