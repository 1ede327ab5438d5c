//! Lost motion that is rough from position to position: of a screw with a bad turn, a cam, a gear.

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Verification;
use trueaxis_diagnose::{Cause, Diagnosis, Verdict};

use crate::iso_run::{curve_um, places, table, values_um};
use crate::{found, generator, report};

const SIGMA_UM: f64 = 0.2;

/// What is lost at x, mm, µm.
type Lost = fn(f64, &[f64]) -> f64;

/// Once around a screw of 50 mm, with no mean: +10 and -10 µm.
fn screw(x_mm: f64, _: &[f64]) -> f64 {
    10.0 * (TAU * x_mm / 50.0).sin()
}

/// 1 µm, and 5 µm where the machine is used most.
fn worn(x_mm: f64, _: &[f64]) -> f64 {
    if (180.0..=230.0).contains(&x_mm) {
        5.0
    } else {
        1.0
    }
}

/// 2 µm, and at each position as much more or less as comes.
fn at_random(x_mm: f64, own: &[f64]) -> f64 {
    let mut places = own.iter().enumerate();
    let is_here = |(k, _): &(usize, &f64)| (20.0 * *k as f64 - x_mm).abs() < 1.0;
    2.0 + places.find(is_here).unwrap().1
}

/// A line of three cycles, and what is lost at each of its positions.
fn line(lost: Lost, seed: u64) -> (Verification, Vec<f64>) {
    let mut generator = generator(seed, 93);
    let places = places(3, &[0.0], &[2.0]);
    let own: Vec<f64> = (0..30)
        .map(|_| StandardNormal.sample(&mut generator))
        .collect();
    let behind = places.iter().map(|place| {
        let side = place.side();
        -0.5 * side * lost(place.x_mm, &own)
    });
    let behind: Vec<f64> = behind.collect();
    let curve = curve_um(&mut generator);
    let values = values_um(&places, &curve, &behind, SIGMA_UM, &mut generator);
    let truth = (0..21).map(|k| lost(20.0 * f64::from(k), &own));
    (table(&places, &values, true), truth.collect())
}

/// Lost motion of the axis along it.
fn lost_motion(found: &Diagnosis) -> Option<&Cause> {
    let mut causes = found.causes.iter();
    causes.find(|cause| cause.effect.effect.id == "position_dependent_backlash")
}

/// Points of the curves of some lines that are inside two standard uncertainties, and all.
fn inside(lost: Lost, seeds: std::ops::Range<u64>) -> [usize; 2] {
    let mut count = [0; 2];
    for seed in seeds {
        let (line, truth) = line(lost, seed);
        let found = found(line);
        let cause = lost_motion(&found).unwrap_or_else(|| panic!("seed {seed}"));
        assert_eq!(cause.curve.len(), truth.len());
        for (point, truth) in cause.curve.iter().zip(&truth) {
            let is_inside = (point.value - truth).abs() < 2.0 * point.u;
            count[0] += usize::from(is_inside);
            count[1] += 1;
        }
    }
    count
}

/// A curve of six half waves was all that was tried: the screw was clean, 3.7 µm beside noise of 0.2, and 301 of 528 points of random ones
/// were outside their intervals. Of 63 points inside with 95 % fewer than 54 are with a probability of 1 %.
#[test]
fn a_curve_follows_what_is_lost_at_each_position() {
    for lost in [screw as Lost, worn, at_random] {
        let [inside, all] = inside(lost, 0..3);
        assert!(all == 63 && inside >= 54, "{inside} of {all}");
    }
}

#[test]
#[ignore = "study: 180 diagnoses"]
fn curves_of_rough_lost_motion_are_inside_their_intervals() {
    for (name, lost) in [
        ("screw", screw as Lost),
        ("worn", worn),
        ("at random", at_random),
    ] {
        let [inside, all] = inside(lost, 100..160);
        report(&format!("{name}: {inside} of {all} points inside"));
        // Points of one line are independent but for its mean; five standard errors.
        let share = inside as f64 / all as f64;
        assert!((0.92..0.98).contains(&share), "{name}: {share}");
    }
}

/// What is the same all along stays so: the free forms have more waves to hide in. One of six does not by chance with a
/// probability of 0.6 % (a tenth of 1 % each).
#[test]
fn constant_lost_motion_stays_constant() {
    let constant = (0..6).filter(|&seed| {
        let (line, _) = line(|_, _| 3.0, seed);
        let found = found(line);
        found.verdict != Verdict::Clean && lost_motion(&found).is_none()
    });
    let constant = constant.count();
    assert_eq!(constant, 6);
}
