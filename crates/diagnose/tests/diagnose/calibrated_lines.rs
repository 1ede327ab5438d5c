//! Lines against a calibration that is itself uncertain.
//!
//! The machine has error curves; a calibration knows them from points with noise, so that its errors are
//! correlated along each axis as in real life.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector, Point3, Vector6};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trueaxis_calibrate::{Settings as Calibrating, calibrate};
use trueaxis_campaign::Campaign;
use trueaxis_diagnose::{Diagnosis, Settings, Verdict, diagnose_against};
use trueaxis_kinematics::{
    ARCSEC, GeometricErrors, LocationError, MICROMETRE, Machine, MotionError,
};
use trueaxis_predict::CalibratedMachine;

use crate::counts::{Counts, summary};
use crate::iso_run::{Place, TARGET_MM, places, table};
use crate::machines::normal;
use crate::three_runs::three_runs;
use crate::{campaign, generator, three_axes};

const SIGMA_UM: f64 = 0.5;
/// Of one coordinate of a measured point.
const POINT_SIGMA_UM: f64 = 0.7;

/// Where X stands at the readings: five cycles there and back, 21 positions each way.
fn stands() -> Vec<Place> {
    places(5, &[0.0], &[1.0])
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
    three_runs([0.0; 3], POINT_SIGMA_UM, |positions, home| {
        let mut at = machine.position(truth, 2, positions, Point3::from(home));
        for c in 0..3 {
            at[c] += POINT_SIGMA_UM * MICROMETRE * normal(generator);
        }
        at
    })
}

/// A machine, its calibration, and the line that is measured on it.
struct Setting {
    calibration: CalibratedMachine,
    campaign: Campaign,
}

/// `form` of x is added to the readings, λ standard deviations of what the readings and the calibration leave of it.
fn setting(seed: u64, lambda: f64, form: impl Fn(f64) -> f64) -> Setting {
    setting_at(&stands(), seed, lambda, form)
}

/// The same with X elsewhere at the readings.
fn setting_at(stands: &[Place], seed: u64, lambda: f64, form: impl Fn(f64) -> f64) -> Setting {
    let mut generator = generator(seed, 5);
    let machine = three_axes();
    let truth = Truth::new(&mut generator);
    let measured = points(&machine, &truth, &mut generator);
    let calibration = calibrate(&measured, &Calibrating::default()).unwrap();
    let calibration = calibration.calibrated_machine();
    let read = |x_mm: f64| {
        let actual = machine.position(&truth, 2, &[x_mm, 0.0, 0.0], TARGET_MM.into());
        (actual.x - TARGET_MM[0] - x_mm) / MICROMETRE
    };
    let trace: Vec<f64> = stands.iter().map(|stand| form(stand.x_mm)).collect();
    let visible = visible(&calibration, stands, &trace);
    let size = if visible > 0.0 { lambda / visible } else { 0.0 };
    let values = stands.iter().zip(&trace).map(|(stand, form)| {
        // The interferometer's zero is anywhere.
        17.0 + read(stand.x_mm) + size * form + SIGMA_UM * normal(&mut generator)
    });
    let values: Vec<f64> = values.collect();
    Setting {
        calibration,
        campaign: campaign(vec![table(stands, &values, false)]),
    }
}

/// `√(tᵀ R t)` with `R = V⁻¹ - V⁻¹1 (1ᵀV⁻¹1)⁻¹ 1ᵀV⁻¹`: a trace in standard deviations, where readings scatter, predictions are
/// uncertain (`V` is the covariance of both), and the zero is unknown.
fn visible(calibration: &CalibratedMachine, stands: &[Place], trace: &[f64]) -> f64 {
    let line = table(stands, trace, false);
    let readings = line.readings.iter();
    let all = readings.map(|r| (&line.kind, &r.positions[..], r.direction));
    let all: Vec<_> = all.collect();
    let noise = DMatrix::identity(trace.len(), trace.len()) * SIGMA_UM.powi(2);
    let weights = (calibration.covariance_of_readings(&all) + noise)
        .try_inverse()
        .unwrap();
    let trace = DVector::from_column_slice(trace);
    let one = DVector::repeat(trace.len(), 1.0);
    let zero = (&weights * &one).dot(&trace) / (&weights * &one).dot(&one);
    let beyond = &trace - one * zero;
    (&weights * &beyond).dot(&beyond).sqrt()
}

fn outcome(setting: &Setting) -> Diagnosis {
    diagnose_against(
        &setting.campaign,
        &setting.calibration,
        &Settings::default(),
    )
    .unwrap()
}

fn assert_silent(of: u64, allowed: usize) {
    let alarms =
        (0..of).filter(|&seed| outcome(&setting(seed, 0.0, |_| 0.0)).verdict != Verdict::Clean);
    let alarms: Vec<u64> = alarms.collect();
    assert!(alarms.len() <= allowed, "seeds {alarms:?}");
}

/// A curve that changed at random at each of 9 positions has waves, too, of which the best was named alone in 14 of 24 such lines. Changes
/// of 12 standard deviations.
#[test]
fn a_curve_that_changed_at_few_positions_has_no_clear_waves() {
    let is_clear = |seed: &u64| {
        let stands = stands().into_iter().filter(|stand| stand.step < 9);
        let stands: Vec<Place> = stands.collect();
        let mut generator = generator(*seed, 106);
        let changes: Vec<f64> = (0..21).map(|_| normal(&mut generator)).collect();
        let Setting {
            calibration,
            campaign,
        } = setting_at(&stands, *seed, 12.0, |x_mm| {
            let mut own = changes.iter().zip(0..);
            let is_here = |k: i32| (x_mm - 20.0 * f64::from(k)).abs() < 10.0;
            own.find(|(_, k)| is_here(*k)).map_or(0.0, |(um, _)| *um)
        });
        let found = diagnose_against(&campaign, &calibration, &Settings::default()).unwrap();
        let mut causes = found.causes.iter();
        causes.any(|cause| cause.effect.effect.id == "cyclic_error" && cause.rivals.is_empty())
    };
    let clear: Vec<u64> = (0..10).filter(is_clear).collect();
    assert!(clear.is_empty(), "{clear:?}");
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
            let mut counts = Counts::default();
            for seed in 0..of {
                let found = outcome(&setting(seed, lambda, form));
                counts.add(&found, effect, Some(0));
            }
            counts.assert_named(of, &format!("λ {lambda}: {effect}"));
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

/// A step of the scale and a dent of the guideway since the calibration wander over the position; what a smooth curve does not follow
/// of them was a clear cyclic error in 15 of these 20. A wave beside a dent keeps its name.
#[test]
fn a_step_or_a_dent_is_no_cyclic_error() {
    let step = |x: f64| if x > 230.0 { 1.0 } else { 0.0 };
    let dent = |x: f64| (-((x - 230.0) / 45.0).powi(2)).exp();
    let wave = |x: f64| dent(x) + 0.5 * (TAU * x / 55.0).sin();
    let has_wave = |found: &Diagnosis| {
        let mut causes = found.causes.iter();
        causes.any(|cause| cause.effect.effect.id == "cyclic_error")
    };
    let mut coarse = places(3, &[0.0], &[1.0]);
    coarse.retain(|place| (place.x_mm / 40.0).fract() < 0.1);
    for seed in 0..5 {
        for lambda in [40.0, 80.0] {
            for form in [&step as &dyn Fn(f64) -> f64, &dent] {
                let found = outcome(&setting_at(&coarse, seed, lambda, form));
                let what = format!("{seed} {lambda}: {}", summary(&found));
                assert!(!has_wave(&found), "{what}");
                assert_eq!(found.verdict, Verdict::Unknown, "{what}");
            }
        }
    }
    for seed in 0..3 {
        let found = outcome(&setting(seed, 40.0, wave));
        assert!(has_wave(&found), "{seed}: {}", summary(&found));
        assert_eq!(found.disturbances.len(), 1, "{seed}");
    }
}
