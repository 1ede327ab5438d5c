//! Positioning of rotary axes. Over a part of a turn any smooth curve is a part of a wave; lost motion may have any form.

use std::cell::Cell;

use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};
use trueaxis_diagnose::{Diagnosis, Rival, Settings, Verdict, diagnose};
use trueaxis_effects::Layer;
use trueaxis_kinematics::{Axis, Machine};

use crate::{campaign, generator};

/// At this distance from the axis a second of arc is a micrometre, mm.
const LEVER_MM: f64 = 206.264_806;

/// What is found in five cycles at so many positions from 0 to so many degrees, from these sides in turn, of readings over the angle
/// and the side of approach, ″, in noise of 0.3″.
fn diagnosed(
    (range_deg, stops): (f64, u32),
    sides: &[Direction],
    reading: &dyn Fn(f64, f64) -> f64,
) -> Diagnosis {
    let mut random: ChaCha8Rng = generator(1, 29);
    let mut readings = Vec::new();
    for cycle in 1..=5 {
        for &direction in sides {
            let sign = f64::from(direction.sign());
            for stop in 0..stops {
                let stop = if sign > 0.0 { stop } else { stops - 1 - stop };
                let angle_deg = range_deg * f64::from(stop) / f64::from(stops - 1);
                let noise: f64 = StandardNormal.sample(&mut random);
                readings.push(VerificationReading {
                    time_s: None,
                    cycle,
                    direction,
                    positions: vec![angle_deg.to_radians()],
                    value_um: reading(angle_deg, sign) + 0.3 * noise,
                    line: readings.len() + 2,
                });
            }
        }
    }
    let kind = VerificationKind::Positioning {
        axis: 0,
        target_mm: Point3::new(LEVER_MM, 0.0, 0.0),
    };
    let mut campaign = campaign(vec![Verification {
        name: "table".into(),
        kind,
        readings,
        u_um: None,
        u_ppm: None,
    }]);
    let travel = [-0.1, range_deg.to_radians() + 0.1];
    let axis = Axis::rotary("C", Vector3::z(), travel, Point3::origin()).unwrap();
    campaign.machine = Machine::new(vec![axis], vec![0], vec![]).unwrap();
    diagnose(&campaign, &Settings::default()).unwrap()
}

fn names(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let causes = diagnosis.causes.iter();
    causes.map(|cause| cause.effect.effect.id).collect()
}

/// Names in the mean curve of readings from one side.
fn names_in(positions: (f64, u32), curve: impl Fn(f64) -> f64) -> Vec<&'static str> {
    names(&diagnosed(
        positions,
        &[Direction::Forward],
        &|angle_deg, _| curve(angle_deg),
    ))
}

/// A bow of 10″ over 3° was "encoder ellipticity of 7300″, U 170″".
#[test]
fn a_bow_over_a_part_of_a_turn_is_no_encoder_error() {
    for range_deg in [3.0, 30.0, 90.0, 140.0] {
        let bow = |angle_deg: f64| 10.0 * (2.0 * angle_deg / range_deg - 1.0).powi(2);
        assert_eq!(names_in((range_deg, 11), bow), [""; 0], "{range_deg}°");
    }
}

/// One wave and a half are not named, and no shorter ones in their place.
#[test]
fn a_worm_that_shows_once_has_no_name() {
    let worm = |angle_deg: f64| 5.0 * (18.0 * angle_deg).to_radians().sin();
    assert_eq!(names_in((30.0, 25), worm), [""; 0]);
}

/// Where they go round once, waves have their names.
#[test]
fn a_whole_wave_is_an_encoder_error() {
    let sine = |waves: f64| move |angle_deg: f64| 10.0 * (waves * angle_deg).to_radians().sin();
    assert_eq!(names_in((350.0, 36), sine(1.0)), ["encoder_eccentricity"]);
    assert_eq!(names_in((200.0, 41), sine(2.0)), ["encoder_ellipticity"]);
    assert_eq!(names_in((30.0, 61), sine(36.0)), ["worm_gear"]);
}

/// Play of 8″ to 14″ over a turn was constant lost motion and something that wanders, or a lag.
#[test]
fn lost_motion_of_a_rotary_axis_may_have_any_form() {
    let play = |angle_deg: f64| 11.0 - 3.0 * angle_deg.to_radians().cos();
    let both = [Direction::Forward, Direction::Backward];
    let diagnosis = diagnosed((350.0, 36), &both, &|angle_deg, side| {
        -0.5 * side * play(angle_deg)
    });
    assert_eq!(names(&diagnosis), ["position_dependent_backlash"]);
    assert_eq!(diagnosis.verdict, Verdict::Named);
    assert!(diagnosis.disturbances.is_empty());
}

/// 20° tell 180 teeth to one or two, 0.76° not to hundred: no number comes without its uncertainty, and none of the thousands between
/// costs its time.
#[test]
fn teeth_of_a_small_part_of_a_turn_are_uncertain() {
    let worm = |angle_deg: f64, _| 2.0 * (180.0 * angle_deg).to_radians().sin();
    let found = diagnosed((20.0, 201), &[Direction::Forward], &worm);
    assert_eq!(names(&found), ["worm_gear"]);
    let parameters = &found.causes[0].parameters;
    let waves = parameters.iter().find(|p| p.name == "waves").unwrap();
    assert!((waves.value - 180.0).abs() < 3.0 * waves.u, "{waves:?}");
    assert!(waves.u > 0.01 && waves.u < 5.0, "{waves:?}");
    // A wave and a half.
    let smooth = |angle_deg: f64, _| 2.0 * (700.0 * angle_deg).to_radians().sin();
    let few = diagnosed((0.76, 20), &[Direction::Forward], &smooth);
    assert_eq!(names(&few), [""; 0]);
}

/// From one side nothing varies with the side of approach: it was said of a drift.
#[test]
fn from_one_side_nothing_varies_with_direction() {
    let found = diagnosed((30.0, 11), &[Direction::Forward], &|_, _| 0.0);
    let tests = found.levels.iter().flat_map(|level| &level.tests);
    let names: Vec<&str> = tests.map(|test| test.varies_with).collect();
    assert!(names.contains(&"time"), "{names:?}");
    assert!(!names.contains(&"direction in time"), "{names:?}");
}

/// An encoder or a clamp that slips shifts the readings as a zero of the instrument that jumps: no shift of the machine turns an axis, so
/// the instrument alone was blamed.
#[test]
fn a_rotary_axis_that_slips_may_be_the_axis() {
    let row = Cell::new(0);
    let both = [Direction::Forward, Direction::Backward];
    let found = diagnosed((330.0, 12), &both, &|_, _| {
        row.set(row.get() + 1);
        if row.get() > 40 { 6.0 } else { 0.0 }
    });
    assert_eq!(names(&found), ["instrument_jump"]);
    assert_eq!(found.verdict, Verdict::Ambiguous);
    let machine = found.causes[0].rivals.iter().any(|rival| match rival {
        Rival::Disturbance { whose, .. } => whose.layer == Layer::Machine,
        Rival::Effect { .. } => false,
    });
    assert!(machine, "{:?}", found.causes[0].rivals);
}

/// Lost motion of a rotary axis that changes along it is told where it was measured, in degrees and seconds of arc: the terminal gave its
/// value in the middle of the travel only.
#[test]
fn lost_motion_of_a_rotary_axis_has_its_curve() {
    let lost = |angle_deg: f64| 6.0 + 5.0 * (angle_deg / 9.0).sin();
    let both = [Direction::Forward, Direction::Backward];
    let found = diagnosed((60.0, 13), &both, &|angle_deg, side| {
        -0.5 * side * lost(angle_deg)
    });
    assert_eq!(found.verdict, Verdict::Named);
    let cause = &found.causes[0];
    assert_eq!(cause.curve.len(), 13);
    for point in &cause.curve {
        assert!(
            (point.value - lost(point.at)).abs() < 4.0 * point.u && point.u < 0.3,
            "{point:?}"
        );
    }
    let mean = (0..13).map(|k| lost(5.0 * f64::from(k))).sum::<f64>() / 13.0;
    let told = cause.mean_lost_motion.as_ref().unwrap();
    assert!(
        (told.value - mean).abs() < 4.0 * told.u && told.unit == "arcsec",
        "{told:?}"
    );
}
