//! Faults that real readings showed, each with a control made for it: formulas of this file, nothing of the diagnosis.

use std::f64::consts::TAU;

use nalgebra::Point3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};
use trueaxis_diagnose::{Cause, Diagnosis, Settings, Verdict, diagnose};
use trueaxis_kinematics::Axis;

use crate::{campaign, found, generator};

const STOPS_MM: [f64; 3] = [0.0, 200.0, 400.0];

/// Cycle, whether from below, and stop of 30 readings; `by_stop` in the order of a step cycle.
fn visits(by_stop: bool) -> Vec<(u32, bool, usize)> {
    let mut visits = Vec::new();
    if by_stop {
        for stop in 0..3 {
            for cycle in 1..=5 {
                visits.extend([true, false].map(|below| (cycle, below, stop)));
            }
        }
    } else {
        for cycle in 1..=5 {
            visits.extend((0..3).map(|stop| (cycle, true, stop)));
            visits.extend((0..3).rev().map(|stop| (cycle, false, stop)));
        }
    }
    visits
}

/// Readings `value(row, below, stop)` with a slope of 10 µm/m and normal noise.
fn line(
    by_stop: bool,
    sigma_um: f64,
    seed: u64,
    value_um: &dyn Fn(usize, bool, usize) -> f64,
) -> Verification {
    let mut generator: ChaCha8Rng = generator(seed, 21);
    let readings = visits(by_stop).into_iter().enumerate();
    let readings = readings.map(|(row, (cycle, below, stop))| {
        let noise: f64 = StandardNormal.sample(&mut generator);
        VerificationReading {
            time_s: None,
            cycle,
            direction: match below {
                true => Direction::Forward,
                false => Direction::Backward,
            },
            positions: vec![STOPS_MM[stop], 0.0, 0.0],
            value_um: 0.01 * STOPS_MM[stop] + value_um(row, below, stop) + sigma_um * noise,
            line: row + 2,
        }
    });
    Verification {
        name: "line".into(),
        kind: VerificationKind::Positioning {
            axis: 0,
            target_mm: Point3::new(100.0, 300.0, 200.0),
        },
        u_um: None,
        u_ppm: None,
        readings: readings.collect(),
    }
}

/// Half of `lost_um` short from below, as far too far from above.
fn lost(lost_um: f64, below: bool) -> f64 {
    if below { -0.5 * lost_um } else { 0.5 * lost_um }
}

fn is_lost_motion(cause: &Cause) -> bool {
    ["backlash", "position_dependent_backlash"].contains(&cause.effect.effect.id)
}

/// 10 µm against 0.5 µm: 20 times the noise, so that a miss has no chance worth a number.
#[test]
fn a_step_cycle_shows_lost_motion_as_sweeps_do() {
    for by_stop in [true, false] {
        for seed in 0..4 {
            let found = found(line(by_stop, 0.5, seed, &|_, below, _| lost(10.0, below)));
            let [cause] = found.causes.as_slice() else {
                panic!("{:?}", found.causes);
            };
            assert_eq!(cause.effect.effect.id, "backlash");
            // Whether it also changes along the axis may stay open: the same cause.
            let rivals: Vec<&str> = cause.rival_effects().map(|r| r.effect.id).collect();
            assert!(
                rivals.iter().all(|r| *r == "position_dependent_backlash"),
                "{rivals:?}"
            );
            assert_eq!(cause.data, ["line"]);
            let lost = &cause.parameters[0];
            assert!((lost.value - 10.0).abs() < 4.0 * lost.u, "{lost:?}");
        }
    }
}

/// Lost motion beside a zero that is another one in each cycle by 4 % of it, read to 0.05 µm: a remainder as clear as the
/// cause, of which it is 0.6 %.
#[test]
fn a_remainder_takes_no_name_away() {
    let zero_um = [-0.4, 0.5, -0.3, 0.4, -0.2];
    for seed in 0..4 {
        let value = |row: usize, below, _| lost(10.0, below) + zero_um[row / 6];
        let found = found(line(false, 0.05, seed, &value));
        let cause = &found.causes[0];
        assert!(is_lost_motion(cause), "{:?}", found.causes);
        assert!(matches!(found.verdict, Verdict::Named | Verdict::Ambiguous));
        assert!(cause.share.unwrap() > 0.98, "{:?}", cause.share);
        // The zeros have 0.39 µm rms; they wander, or nothing explains them.
        let wandering = found.disturbances.iter().map(|d| d.rms_um);
        let left = found.unexplained.iter().map(|u| u.rms_um);
        let left_um = wandering.chain(left).fold(0.0, f64::hypot);
        assert!((0.25..0.5).contains(&left_um), "{:?}", found.disturbances);
        assert_shares_add_up(&found);
    }
}

fn assert_shares_add_up(found: &Diagnosis) {
    for level in &found.levels {
        let shares = &level.shares;
        let parts = shares
            .causes
            .iter()
            .chain(&shares.disturbances)
            .chain([&shares.unexplained, &shares.noise]);
        assert!(
            parts.clone().all(|part| (0.0..=1.0).contains(part)),
            "{shares:?}"
        );
        let sum: f64 = parts.sum();
        assert!((sum - 1.0).abs() < 1e-9, "{shares:?}");
    }
}

#[test]
fn lost_motion_below_zero_is_over_compensation() {
    let too_far = found(line(true, 0.5, 1, &|_, below, _| lost(-6.0, below)));
    let explanation = too_far.causes[0].effect.explanation();
    assert!(explanation.cause.contains("too far"), "{explanation:?}");
    let short = found(line(true, 0.5, 1, &|_, below, _| lost(6.0, below)));
    let explanation = short.causes[0].effect.explanation();
    assert!(explanation.cause.contains("lost motion"), "{explanation:?}");
}

/// A gross error of 300 µm among 2 µm, at each row once, in both orders.
#[test]
fn a_gross_error_is_left_out_and_said() {
    for by_stop in [true, false] {
        for wrong in (0..30).step_by(7) {
            let value = |row: usize, _, _| if row == wrong { 300.0 } else { 0.0 };
            let found = found(line(by_stop, 2.0, wrong as u64, &value));
            let rows: Vec<usize> = found.rejected.iter().map(|r| r.row).collect();
            assert_eq!(rows, [wrong + 2], "{:?}", found.rejected);
            let error_um = found.rejected[0].error_um;
            assert!((200.0..400.0).contains(&error_um), "{error_um}");
            assert!(found.causes.is_empty(), "{:?}", found.causes);
        }
    }
}

/// At 1e-4 for each file more than one of 40 has a chance of 8e-6.
#[test]
fn readings_in_order_are_kept() {
    let kept = (0..40).filter(|&seed| {
        let found = found(line(seed % 2 == 0, 1.0, seed, &|_, _, _| 0.0));
        found.rejected.is_empty()
    });
    assert!(kept.count() >= 39);
}

/// The zero of the reading instrument wanders off evenly by 15 µm: nothing in one file tells it from a machine that
/// drifts, so it must be among the names.
#[test]
fn the_instrument_is_a_suspect() {
    for seed in 0..4 {
        let found = found(line(false, 0.5, seed, &|row, _, _| -0.5 * row as f64));
        let names = found.causes.iter().flat_map(|cause| {
            let rivals = cause.rival_effects().map(|r| r.effect.id);
            rivals.chain([cause.effect.effect.id])
        });
        let names: Vec<&str> = names.collect();
        assert!(names.contains(&"instrument_drift"), "{names:?}");
        assert!(names.contains(&"machine_drift"), "{names:?}");
        assert_eq!(found.verdict, Verdict::Ambiguous);
        // Rows are no seconds.
        let parameters = found.causes.iter().flat_map(|cause| &cause.parameters);
        assert!(
            parameters.clone().all(|p| p.unit != "s"),
            "{:?}",
            found.causes
        );
    }
}

/// A scale that would have to grow by 1 % within the readings is no expansion.
#[test]
fn impossible_sizes_are_not_named() {
    let value = |row: usize, _, stop: usize| 1e-2 * STOPS_MM[stop] * row as f64 / 29.0 * 1e3;
    let found = found(line(false, 0.5, 1, &value));
    let effects = found.causes.iter().map(|cause| cause.effect.effect.id);
    let effects: Vec<&str> = effects.collect();
    assert!(!effects.contains(&"axis_expansion"), "{effects:?}");
}

/// One pass in one direction contradicts nothing.
#[test]
fn nothing_judged_is_not_clean() {
    let mut once = line(false, 0.5, 1, &|_, _, _| 0.0);
    once.readings.truncate(3);
    let found = found(once);
    assert_eq!(found.verdict, Verdict::NotJudged);
    assert_eq!(found.verdict.name(), "not_judged");
    assert!(!found.verdict.is_misfit());
}

/// Neighbours of noise alone keep their share of noise.
#[test]
fn shares_of_noise_add_up() {
    let mut random: ChaCha8Rng = generator(3, 22);
    let sigma_um = 0.2 + random.random::<f64>();
    assert_shares_add_up(&found(line(true, sigma_um, 5, &|_, _, _| 0.0)));
}

/// A wave of 4 µm with a pitch of 50 mm on a curve that bends by 10 µm, read once in one direction, noise 0.2 µm.
#[test]
fn a_wave_on_a_smooth_curve_is_found_in_a_line_without_calibration() {
    let mut random: ChaCha8Rng = generator(7, 23);
    let positions = (0..=60).map(|k| 6.5 * f64::from(k));
    let once = read_once(positions, |x_mm| {
        let noise: f64 = StandardNormal.sample(&mut random);
        let wave = 4.0 * (TAU * x_mm / 50.0 + 0.4).sin();
        10.0 * (x_mm / 390.0).powi(2) + wave + 0.2 * noise
    });
    let found = found(once);
    // It contradicts nothing.
    assert_eq!(found.verdict, Verdict::NotJudged);
    let cause = found
        .causes
        .iter()
        .find(|c| c.effect.effect.id == "cyclic_error")
        .unwrap();
    assert_eq!(cause.data, ["mean curve of line"]);
    let value = |name: &str| {
        cause
            .parameters
            .iter()
            .find(|p| p.name == name)
            .unwrap()
            .value
    };
    assert!(
        (value("period") - 50.0).abs() < 0.5,
        "{:?}",
        cause.parameters
    );
    assert!(
        (value("amplitude") - 4.0).abs() < 0.5,
        "{:?}",
        cause.parameters
    );
}

/// A line that is read once, in one direction.
fn read_once(
    positions_mm: impl Iterator<Item = f64>,
    mut read_um: impl FnMut(f64) -> f64,
) -> Verification {
    let mut once = line(false, 0.0, 1, &|_, _, _| 0.0);
    let reading = once.readings[0].clone();
    let read = |(k, x_mm)| {
        let mut reading = reading.clone();
        reading.positions[0] = x_mm;
        reading.value_um = read_um(x_mm);
        reading.line = 2 + k;
        reading
    };
    once.readings = positions_mm.enumerate().map(read).collect();
    once
}

/// Waves of 20 and 1.5 µm with 0.25 and 0.083 mm on a curve of the fourth degree, read every 0.02 mm over 3 mm, noise 0.5 µm: the
/// phase at zero hangs on the period, the more the further away the positions are.
#[test]
fn a_wave_that_is_short_beside_its_position_has_an_honest_phase() {
    let (mut squares, mut count) = (0.0, 0);
    for seed in 0..6 {
        let mut random: ChaCha8Rng = generator(seed, 27);
        let truth: Vec<(f64, f64)> = [0.25, 0.083]
            .map(|period_mm| (period_mm, TAU * random.random::<f64>()))
            .into();
        let bend: Vec<f64> = (0..5).map(|_| StandardNormal.sample(&mut random)).collect();
        let found = found(read_once(
            (0..=150).map(|k| 2.0 + 0.02 * f64::from(k)),
            |x_mm| {
                let noise: f64 = StandardNormal.sample(&mut random);
                let t = (x_mm - 3.5) / 1.5;
                let bent: f64 = bend.iter().rev().fold(0.0, |sum, b| sum * t + 5.0 * b);
                let waves = truth.iter().zip([20.0, 1.5]);
                let waves = waves
                    .map(|((period_mm, phase), um)| um * (TAU * x_mm / period_mm + phase).sin());
                bent + waves.sum::<f64>() + 0.5 * noise
            },
        ));
        for (period_mm, phase) in &truth {
            let of_wave = |cause: &&Cause| {
                let period = cause.parameters.iter().find(|p| p.name == "period");
                period.is_some_and(|p| (p.value / period_mm - 1.0).abs() < 0.02)
            };
            let cause = found.causes.iter().find(of_wave).unwrap();
            let estimated = |name: &str| {
                let parameter = cause.parameters.iter().find(|p| p.name == name).unwrap();
                (parameter.value, parameter.u)
            };
            let (value_deg, u_deg) = estimated("phase");
            let turns = (value_deg - phase.to_degrees()) / 360.0;
            let z = 360.0 * (turns - turns.round()) / u_deg;
            let (period, u_period) = estimated("period");
            squares += z.powi(2) + ((period - period_mm) / u_period).powi(2);
            count += 2;
        }
    }
    // Phase and period are as good as one number, so that some twelve count: the mean of as many squares is between 0.2
    // and 2.2 with 99 %; what bends is smoother than is assumed, which makes u wider.
    let mean = squares / f64::from(count);
    assert!((0.2..2.2).contains(&mean), "{mean}");
}

/// Two stops 0.5 mm apart at each of eight places, noise alone: the gaps leave room for a wave of any length.
#[test]
fn groups_of_stops_show_no_wave() {
    for seed in 0..4 {
        let mut random: ChaCha8Rng = generator(seed, 24);
        let positions = (0..8).flat_map(|k| [50.0 * f64::from(k), 50.0 * f64::from(k) + 0.5]);
        let once = read_once(positions, |_| StandardNormal.sample(&mut random));
        assert!(found(once).causes.is_empty());
    }
}

/// A counter of steps repeats to its last digit: no noise is left, and nothing may be divided by it.
#[test]
fn readings_that_repeat_to_the_last_digit_are_judged_by_that_digit() {
    let said = |value_um: &dyn Fn(usize, bool) -> f64| {
        let digits = |row: usize, below: bool, stop: usize| {
            // The line has a slope of 10 µm/m of its own.
            let true_um = 0.01 * STOPS_MM[stop] + value_um(row, below);
            (100.0 * true_um).round() / 100.0 - 0.01 * STOPS_MM[stop]
        };
        found(line(true, 0.0, 0, &digits))
    };
    let same = said(&|_, _| 0.7);
    assert_eq!(same.verdict, Verdict::Clean);
    // One reading is off by its last digit: that is no gross error.
    let digit = said(&|row, _| if row == 7 { 0.71 } else { 0.7 });
    assert_eq!(digit.verdict, Verdict::Clean);
    assert!(digit.rejected.is_empty());
    let apart = said(&|_, below| lost(0.1, below));
    assert!(apart.causes.iter().any(is_lost_motion));
}

#[test]
fn equal_readings_are_not_judged() {
    let equal = found(line(true, 0.0, 0, &|_, _, stop| {
        0.7 - 0.01 * STOPS_MM[stop]
    }));
    assert_eq!(equal.verdict, Verdict::NotJudged);
}

/// Nine stops 50 mm apart, five cycles, both sides, each `b(q)/2` from the middle.
fn sides_apart(seed: u64, b_um: impl Fn(f64) -> f64) -> Verification {
    let mut random: ChaCha8Rng = generator(seed, 25);
    let mut apart = line(false, 0.0, 1, &|_, _, _| 0.0);
    let pattern = apart.readings[0].clone();
    let mut readings = Vec::new();
    for cycle in 1..=5 {
        let up = (0..9).map(|k| (true, k));
        for (below, stop) in up.chain((0..9).rev().map(|k| (false, k))) {
            let x_mm = 50.0 * f64::from(stop);
            let noise: f64 = StandardNormal.sample(&mut random);
            let mut reading = VerificationReading {
                cycle,
                direction: if below {
                    Direction::Forward
                } else {
                    Direction::Backward
                },
                value_um: lost(b_um(x_mm), below) + 0.5 * noise,
                line: readings.len() + 2,
                ..pattern.clone()
            };
            reading.positions[0] = x_mm;
            readings.push(reading);
        }
    }
    apart.readings = readings;
    apart
}

/// A worn middle, 8 µm of play over 2 at the ends: no straight line, and named all the same, with its curve.
#[test]
fn lost_motion_is_a_free_function_of_the_position() {
    let worn = |x_mm: f64| 2.0 + 8.0 * (-((x_mm - 200.0) / 80.0).powi(2)).exp();
    let (mut inside, mut all) = (0, 0);
    for seed in 0..10 {
        let diagnosis = found(sides_apart(seed, worn));
        assert_eq!(diagnosis.verdict, Verdict::Named, "{:?}", diagnosis.causes);
        let cause = &diagnosis.causes[0];
        assert_eq!(cause.effect.effect.id, "position_dependent_backlash");
        assert_eq!(cause.curve.len(), 9);
        for point in &cause.curve {
            let error = (point.value - worn(point.at)).abs();
            inside += usize::from(error < 2.0 * point.u);
            all += 1;
        }
    }
    // 86 of 90 are expected; fewer than 74 by chance less than once in a thousand, even if the nine of a line were two.
    assert!(inside >= 74, "{inside} of {all}");
}

/// In the middle of a long travel, where nobody measured, the straight line through falling play is far below zero.
#[test]
fn lost_motion_is_told_where_it_was_measured() {
    let falling = |x_mm: f64| 10.0 - 0.02 * x_mm;
    let again = Verification {
        name: "again".to_owned(),
        ..sides_apart(5, falling)
    };
    for lines in [
        vec![sides_apart(4, falling)],
        vec![sides_apart(4, falling), again],
    ] {
        let files = lines.len();
        let mut campaign = campaign(lines);
        campaign.machine = campaign.machine.with_axes(|_, axis| {
            let direction = axis.direction().into_inner();
            Axis::linear(axis.name(), direction, [0.0, 2000.0]).unwrap()
        });
        let diagnosis = diagnose(&campaign, &Settings::default()).unwrap();
        let cause = &diagnosis.causes[0];
        assert_eq!((diagnosis.causes.len(), cause.data.len()), (1, files));
        assert!(cause.parameters[0].value < -5.0, "{:?}", cause.parameters);
        assert_eq!(cause.curve.len(), 9);
        let mean = cause.mean_lost_motion.as_ref().unwrap();
        assert!(
            mean.u < 0.2 && (mean.value - 6.0).abs() < 4.0 * mean.u,
            "{mean:?}"
        );
        assert_eq!(cause.told_parameters()[0], *mean);
        // From one end to the other it is no wear in the middle.
        assert!(!cause.explanation().cause.contains("worn"));
    }
}

/// 4 µm more in the middle half of the travel, at nine positions: wear is said. At three it is not, whatever they show.
#[test]
fn wear_is_said_of_play_that_is_largest_in_the_middle() {
    let worn = |x_mm: f64| 3.0 + 2.0 * (1.0 - (TAU * x_mm / 400.0).cos());
    let said = |line: Verification| {
        let diagnosis = found(line);
        let cause = &diagnosis.causes[0];
        assert!(is_lost_motion(cause));
        cause.explanation().cause.contains("worn")
    };
    assert!(said(sides_apart(3, worn)));
    let mut short = sides_apart(10, worn);
    let is_kept = |x_mm: f64| [0.0, 200.0, 400.0].contains(&x_mm);
    short.readings.retain(|r| is_kept(r.positions[0]));
    assert!(!said(short));
}

/// Play has one sign; what the sides differ by otherwise is not called wear.
#[test]
fn sides_that_differ_by_both_signs_are_no_wear() {
    let waves = |x_mm: f64| 6.0 * (TAU * x_mm / 400.0).sin();
    let diagnosis = found(sides_apart(3, waves));
    let cause = &diagnosis.causes[0];
    assert!(is_lost_motion(cause));
    assert!(cause.explanation().cause.contains("changes its sign"));
}

/// The simpler form is kept where it suffices: constant play is not given a curve.
#[test]
fn constant_lost_motion_has_no_curve() {
    let counts = (0..20).filter(|&seed| {
        let diagnosis = found(sides_apart(seed, |_| 3.0));
        diagnosis.causes.iter().all(|cause| cause.curve.is_empty())
    });
    // A curve where there is none is decided at the level of 0.01: 0.2 of 20 are expected.
    assert!(counts.count() >= 18);
}
