//! Lines and circles against a calibration that is itself uncertain.
//!
//! The machine has error curves; a calibration knows them from points with noise, so that its errors are
//! correlated along each axis as in real life.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector6};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_calibrate::{Calibration, Settings, calibrate};
use trueaxis_campaign::{Campaign, Direction, PointReading, Points, Run, Step, Stop, Target};
use trueaxis_kinematics::{
    ARCSEC, GeometricErrors, LocationError, MICROMETRE, Machine, MotionError,
};

use super::iso_run::{Place, places, table};
use super::lines::report;
use super::{Counts, campaign, generator, length, scene, summary, three_axes};
use crate::Verdict;
use crate::verification::base::base_columns;
use crate::verification::comparison::Comparison;
use crate::verification::prediction_error::{prediction_directions, with_reference_points};
use crate::verification::problem::Problem;
use crate::verification::{EntryOutcome, diagnose_verification};

const SIGMA_UM: f64 = 0.5;
/// Of one coordinate of a measured point.
const POINT_SIGMA_UM: f64 = 0.7;
const TARGET_MM: [f64; 3] = [100.0, 300.0, 200.0];

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
            carrier: 2,
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
                run: axis,
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
    calibration: Calibration,
    campaign: Campaign,
}

/// `form` of x is added to the readings with λ in the sight of the diagnosis' projection.
fn setting(seed: u64, lambda: f64, form: impl Fn(f64) -> f64, covariance: bool) -> Setting {
    let mut generator = generator(seed, 5);
    let machine = three_axes();
    let truth = Truth::new(&mut generator);
    let settings = Settings {
        covariance,
        ..Settings::default()
    };
    let calibration = calibrate(&points(&machine, &truth, &mut generator), &settings).unwrap();
    let places = places(5, &[0.0], &[2.0]);
    let read = |place: &Place| {
        let positions = [place.x_mm, place.y_mm, 0.0];
        let actual = machine.position(&truth, 2, &positions, TARGET_MM.into());
        (actual.x - TARGET_MM[0] - place.x_mm) / MICROMETRE
    };
    let bare: Vec<f64> = places.iter().map(read).collect();
    let trace: Vec<f64> = places.iter().map(|p| form(p.x_mm)).collect();
    let visible = length(&beyond_the_prediction(
        &calibration,
        &table(&places, &trace, false),
    ));
    let size = if visible > 0.0 { lambda / visible } else { 0.0 };
    let values = bare.iter().zip(&trace).map(|(bare, x)| {
        let noise: f64 = StandardNormal.sample(&mut generator);
        // The interferometer's zero is anywhere.
        17.0 + bare + size * x + SIGMA_UM * noise
    });
    let values: Vec<f64> = values.collect();
    Setting {
        calibration,
        campaign: campaign(vec![table(&places, &values, false)]),
    }
}

/// What the base model with the calibration's uncertainty leaves of a trace given as readings, in
/// standard deviations.
fn beyond_the_prediction(
    calibration: &Calibration,
    trace: &trueaxis_campaign::Verification,
) -> Vec<f64> {
    let machine = with_reference_points(&three_axes(), calibration);
    let comparison = Comparison::new(&machine, trace, &trueaxis_kinematics::Ideal);
    let directions = prediction_directions(&comparison, calibration, SIGMA_UM);
    let base = base_columns(&comparison, true);
    let scene = scene(&campaign(Vec::new()));
    Problem::new(&comparison, &scene, SIGMA_UM, &base, &directions)
        .base
        .residuals
}

fn outcome(setting: &Setting) -> EntryOutcome {
    let scene = scene(&setting.campaign);
    let outcome = diagnose_verification(&setting.campaign, Some(&setting.calibration), &scene);
    outcome.entries.into_iter().next().unwrap()
}

/// As [`super::clean`]; 6 of 60 come with a probability of 2e-3 at a rate of 2 %.
#[test]
fn a_calibration_within_its_uncertainty_raises_no_alarm() {
    for covariance in [true, false] {
        let mut alarms = Vec::new();
        for seed in 0..60 {
            let found = outcome(&setting(seed, 0.0, |_| 0.0, covariance));
            if found.verdict != Verdict::Clean {
                alarms.push(summary(&found));
            }
        }
        report(&format!(
            "covariance {covariance}: {} false alarms of 60: {alarms:?}",
            alarms.len()
        ));
        assert!(alarms.len() < 6, "{alarms:?}");
    }
}

/// A trace over x.
type Form = fn(f64) -> f64;

/// Scale and cyclic error beyond the calibration.
#[test]
fn each_effect_is_named() {
    let cyclic: Form = |x| (TAU * x / 63.0 + 0.4).sin();
    let cases: [(&str, Form); 2] = [("scale_error", |x| x), ("cyclic_error", cyclic)];
    for lambda in [7.0, 20.0] {
        for (effect, form) in cases {
            let mut counts = Counts::default();
            for seed in 0..20 {
                counts.add(
                    &outcome(&setting(seed, lambda, form, true)),
                    effect,
                    Some(0),
                );
            }
            let line = format!("λ {lambda}: with a calibration: {effect}: {counts:?}");
            report(&line);
            assert!(counts.right() >= 18, "{line}");
            assert!(counts.wrong <= 1, "{line}");
        }
    }
}
