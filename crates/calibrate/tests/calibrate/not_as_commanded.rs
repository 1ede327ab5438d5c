//! Axes that move otherwise than commanded.

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use trueaxis_calibrate::{Error, Settings, calibrate};
use trueaxis_simulate::Term;

use crate::propagation::points::points_campaign;
use crate::{simulated, two_branches};

/// An encoder that is off by eight degrees, four times in a turn: direction, sign and unit are right, and the message does not stop
/// there.
#[test]
fn an_encoder_that_is_off_by_degrees_is_no_wrong_sign_alone() {
    let mut scenario = two_branches();
    let errors = scenario.errors.entry("C".to_owned()).or_default();
    let off = Term::Sine {
        amplitude: 8.0 * 3600.0,
        period_mm: None,
        period_deg: Some(90.0),
        phase_deg: 0.0,
    };
    errors.components.insert("ECC".to_owned(), vec![off]);
    let error = calibrate(&simulated(&scenario), &Settings::default()).unwrap_err();
    let said = error.to_string();
    for part in [
        "axis C does not move as commanded: in run c at ",
        // 8° sin(4 · 75°), the most of the five positions.
        "C = 75° the points deviate by 0.0 mm and 6.9° from it",
        "repaired",
    ] {
        assert!(said.contains(part), "{said}");
    }
}

/// The error of points of the table that are displaced from 150° on, as seen from the table, by a motion.
fn error_of_points_displaced_by(motion: &Isometry3<f64>, repeats: u32) -> Error {
    let mut campaign = points_campaign(simulated(&two_branches()), repeats, &Isometry3::identity());
    let (steps, runs) = (&campaign.steps, &campaign.runs);
    let points = campaign.points.as_mut().unwrap();
    for stop in &points.stops {
        let (run, angle_rad) = (steps[stop.step].run, steps[stop.step].positions[2]);
        if run.is_some_and(|run| runs[run].name == "c") && angle_rad > 2.0 {
            let turn = turned_about_c(angle_rad);
            for reading in &mut points.readings[stop.readings.clone()] {
                reading.position_mm = turn * motion * turn.inverse() * reading.position_mm;
            }
        }
    }
    calibrate(&campaign, &Settings::default()).unwrap_err()
}

fn turned_about_c(angle_rad: f64) -> Isometry3<f64> {
    let centre_mm = Point3::new(200.0, 150.0, 0.0);
    let turn = Isometry3::rotation(Vector3::z() * angle_rad);
    Translation3::from(centre_mm) * turn * Translation3::from(centre_mm).inverse()
}

/// Of targets that were remounted the message blamed the axis, and the step after it alone.
#[test]
fn remounted_targets_are_told_from_an_axis_that_jumped() {
    let displaced_mm = Vector3::new(60.0, 20.0, -70.0);
    let remounted: Isometry3<f64> = Translation3::from(displaced_mm).into();
    let jumped = turned_about_c(20_f64.to_radians());
    // Target W is farthest from the axis.
    let chord_mm = 2.0 * 10_f64.to_radians().sin() * 168.5;
    for (repeats, motion, size_mm, speaks) in [
        (1, remounted, displaced_mm.norm(), "for the targets"),
        (1, jumped, chord_mm, "that fits both"),
        // The first steps were measured again, and the targets were back.
        (2, remounted, displaced_mm.norm(), "against the targets"),
    ] {
        let error = error_of_points_displaced_by(&motion, repeats);
        let Error::DisplacedOnce(found) = &error else {
            panic!("{error}");
        };
        let [before, after] = [75, 150].map(|c| format!("run c at X = 0 mm, Y = 0 mm, C = {c}°"));
        assert_eq!(found.between, format!("{before} and {after}"));
        // The best fit of all targets takes some of it.
        assert!((found.displaced_mm / size_mm - 1.0).abs() < 0.2, "{error}");
        assert_eq!(found.jump == "20°", motion == jumped, "{error}");
        assert!(found.conclusion.contains(speaks), "{error}");
    }
}
