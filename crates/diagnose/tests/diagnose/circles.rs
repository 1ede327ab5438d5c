//! Ordinary circles: play of both axes, their squareness, scales and servos are all there at once, and rows fall where they fall.

use std::f64::consts::{FRAC_PI_2, TAU};

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationReading};
use trueaxis_diagnose::{Diagnosis, Verdict};

use crate::ball_bar::{CENTRE_MM, in_xy};
use crate::counts::summary;
use crate::{found, found_in, generator, report};

const RADIUS_MM: f64 = 150.0;
const FEED_MM_S: f64 = 1000.0 / 60.0;
const NOISE_UM: f64 = 0.3;

/// What is wrong with X and Y: play, µm; how much later X comes than Y, ms; how much Y leans, ″; how much longer X is than Y, ppm; and how
/// much the zero of the bar drifts, µm/s.
#[derive(Debug, Clone, Copy, Default)]
struct Wrong {
    play_um: [f64; 2],
    lag_ms: f64,
    leans_arcsec: f64,
    longer_ppm: f64,
    drift_um_s: f64,
}

/// Two turns and two back, from an angle on, closed; steps and angles in degrees.
fn circle(wrong: Wrong, grid: (f64, f64), seed: u64) -> Verification {
    circle_of(RADIUS_MM, wrong, grid, seed)
}

/// The same of another radius.
fn circle_of(
    radius_mm: f64,
    wrong: Wrong,
    (start_deg, step_deg): (f64, f64),
    seed: u64,
) -> Verification {
    let mut random = generator(seed, 96);
    let set_up: [f64; 3] = std::array::from_fn(|_| random.random_range(-20.0..20.0));
    let rows: usize = (0..720)
        .find(|&row| step_deg * row as f64 > 360.0 - 0.1)
        .unwrap();
    let mut readings = Vec::new();
    let mut time_s = 0.0;
    for sweep in 0..4_u32 {
        let sense = if sweep % 2 == 0 { 1.0 } else { -1.0 };
        for row in 0..=rows {
            let angle = (start_deg + sense * step_deg * row as f64).to_radians();
            // At the very end of its way an axis is still on the side that it came from.
            let came = angle - sense * 1e-6;
            let moves = [-sense * came.sin(), sense * came.cos()];
            let [x, y] = [angle.cos(), angle.sin()].map(|part| radius_mm * part);
            let speed_x = -sense * FEED_MM_S * angle.sin();
            let off_x = -0.5 * wrong.play_um[0] * moves[0].signum() - wrong.lag_ms * speed_x
                + 1e-3 * wrong.longer_ppm * x
                - wrong.leans_arcsec * y * TAU / 1.296e3;
            let off_y = -0.5 * wrong.play_um[1] * moves[1].signum();
            let noise: f64 = StandardNormal.sample(&mut random);
            let ball = (x + 1e-3 * (off_x + set_up[0])).hypot(y + 1e-3 * (off_y + set_up[1]));
            readings.push(VerificationReading {
                time_s: Some(time_s),
                cycle: 1 + sweep / 2,
                direction: if sense > 0.0 {
                    Direction::Forward
                } else {
                    Direction::Backward
                },
                positions: vec![CENTRE_MM[0] + x, CENTRE_MM[1] + y, 0.0],
                value_um: 1e3 * (ball - radius_mm)
                    + set_up[2]
                    + wrong.drift_um_s * time_s
                    + NOISE_UM * noise,
                line: readings.len() + 2,
            });
            time_s += step_deg.to_radians() * radius_mm / FEED_MM_S;
        }
        time_s += 5.0;
    }
    in_xy(readings)
}

/// Each value that is found, and what it is in truth: X later is Y earlier, and X longer is Y shorter. None for what was not there.
fn against_truth(found: &Diagnosis, wrong: Wrong) -> Vec<(&'static str, f64, f64, Option<f64>)> {
    let causes = found.causes.iter();
    let of_cause = causes.map(|cause| {
        let own = &cause.parameters[0];
        let axis = cause.effect.subject.axis.unwrap_or(9);
        let of_x_less_y = |size: f64| if axis == 0 { size } else { -size };
        let truth = match cause.effect.effect.id {
            "backlash" => wrong.play_um.get(axis).copied(),
            "timestamp_offset" if own.unit == "ms" => Some(of_x_less_y(-wrong.lag_ms)),
            "timestamp_offset" => Some(of_x_less_y(-wrong.lag_ms / BETWEEN_READINGS_S)),
            "squareness_error" => Some(wrong.leans_arcsec),
            "scale_error" => Some(of_x_less_y(wrong.longer_ppm)),
            _ => None,
        };
        (cause.effect.effect.id, own.value, own.u, truth)
    });
    of_cause.collect()
}

/// All that is wrong is named, and nothing else, each value within so many standard uncertainties.
fn assert_is(found: &Diagnosis, wrong: Wrong, count: usize, what: &str) {
    assert_eq!(found.causes.len(), count, "{what}: {}", summary(found));
    assert!(
        found.disturbances.is_empty() && found.unexplained.is_none(),
        "{what}"
    );
    assert_ne!(found.verdict, Verdict::Unknown, "{what}");
    for (id, value, u, truth) in against_truth(found, wrong) {
        let truth = truth.unwrap_or_else(|| panic!("{what}: {id}"));
        assert!(
            (value - truth).abs() < 4.0 * u,
            "{what}: {id} {value} ± {u}, {truth}"
        );
    }
}

const AT_ONCE: Wrong = Wrong {
    play_um: [3.0, 4.0],
    lag_ms: 0.1,
    leans_arcsec: 5.0,
    longer_ppm: 20.0,
    drift_um_s: 0.0,
};

/// Rows at the quadrants had no side, the first and the last a wrong one: play of Y was lost, and that of X half of what it is. What explains
/// less than a twentieth of what play does was taken for its shape: 6.15 ± 0.07 instead of 4 and 0.15 ms. A coupling took the places of
/// squareness and scale. Of eleven values one is beyond four u with a probability of 0.07 %.
#[test]
fn all_that_is_wrong_with_a_circle_is_told() {
    let play = Wrong {
        play_um: [6.0, 4.0],
        ..Wrong::default()
    };
    let play_and_lag = Wrong {
        play_um: [4.0, 0.0],
        lag_ms: 0.15,
        ..Wrong::default()
    };
    let square_and_scale = Wrong {
        leans_arcsec: 8.0,
        longer_ppm: 20.0,
        ..Wrong::default()
    };
    for (wrong, count, grid) in [
        (play, 2, (0.0, 5.0)),
        (play_and_lag, 2, (45.7, 3.0)),
        (square_and_scale, 2, (0.0, 5.0)),
        (AT_ONCE, 5, (2.5, 5.0)),
    ] {
        let what = format!("{grid:?}, {wrong:?}");
        assert_is(&found(circle(wrong, grid, 2)), wrong, count, &what);
    }
}

/// A coupling is nearly squareness and scale, with a third harmonic for which a wave makes up. The 2 ln B of that pair counted what a
/// wave of any period explains before a coupling is there, and both were named in 17 of 30 such tables.
#[test]
fn squareness_and_scale_are_no_wave_beside_a_coupling() {
    let wrong = Wrong {
        leans_arcsec: 4.0,
        longer_ppm: 17.3,
        ..Wrong::default()
    };
    for seed in 30..33 {
        let found = found(circle_of(100.0, wrong, (0.0, 3.0), seed));
        assert_is(&found, wrong, 2, &format!("seed {seed}"));
    }
}

/// Rows are missing beside the end of travel where the circle begins: a chord over uneven steps has the new direction already. With the
/// wrong side at the first and last row of each pass squareness was lost, and play changed along the axis in 6 of 6 such tables, with a
/// mean of 1.7 to 2.8 µm. Of six values one is beyond four u with a probability of 0.04 %.
#[test]
fn rows_that_are_missing_leave_the_sides_as_they_are() {
    let wrong = Wrong {
        play_um: [3.0, 0.0],
        leans_arcsec: 6.0,
        ..Wrong::default()
    };
    let rows_of_pass = 121;
    for missing in 1..=3 {
        let bar = circle(wrong, (0.0, 3.0), 20);
        let rows = bar.readings.iter().enumerate();
        let kept = rows.filter(|(row, _)| !(1..=missing).contains(&(row % rows_of_pass)));
        let readings = kept.map(|(_, reading)| reading.clone()).collect();
        let bar = Verification { readings, ..bar };
        assert_is(&found(bar), wrong, 2, &format!("{missing} rows"));
    }
}

/// Between readings 3° apart.
const BETWEEN_READINGS_S: f64 = TAU / 120.0 * RADIUS_MM / FEED_MM_S;

/// As reports print it.
fn without_a_clock(mut bar: Verification) -> Verification {
    for reading in &mut bar.readings {
        reading.time_s = None;
    }
    bar
}

/// Without a clock nothing was late: lag alone was a machine that wanders, and play of 4 µm beside it 6.10 ± 0.08 µm.
#[test]
fn a_circle_without_a_clock_shows_what_lags() {
    for (play_um, count) in [(0.0, 1), (4.0, 2)] {
        let wrong = Wrong {
            play_um: [play_um, 0.0],
            lag_ms: 0.15,
            ..Wrong::default()
        };
        for seed in 3..5 {
            let bar = without_a_clock(circle(wrong, (45.7, 3.0), seed));
            assert_is(&found(bar), wrong, count, &format!("{play_um} {seed}"));
        }
    }
}

/// Two tables without a clock, of other steps: each has its own interval between readings, and lag in parts of it.
#[test]
fn lag_without_a_clock_is_of_one_table() {
    let wrong = Wrong {
        lag_ms: 0.15,
        ..Wrong::default()
    };
    let bars = [3.0, 5.0].map(|step| without_a_clock(circle(wrong, (45.7, step), 7)));
    let found = found_in(bars.into());
    let sizes = found.causes.iter().map(|cause| {
        assert_eq!(cause.parameters[0].unit, "readings/1000");
        cause.parameters[0].value.abs()
    });
    let sizes: Vec<f64> = sizes.collect();
    let [narrow, wide] = sizes[..] else {
        panic!("{}", summary(&found));
    };
    assert!((narrow / wide - 5.0 / 3.0).abs() < 0.15, "{narrow} {wide}");
}

/// The end of a circle is where it began, but later: while the bar drifts it is off by as much as that, and was left out in
/// one circle of three.
#[test]
fn the_end_of_a_circle_is_not_its_start() {
    for seed in 0..4 {
        let wrong = Wrong {
            drift_um_s: 0.035,
            ..Wrong::default()
        };
        let found = found(without_a_clock(circle(wrong, (0.0, 3.0), seed)));
        assert!(found.rejected.is_empty(), "{seed}: {:?}", found.rejected);
        let [drift] = &found.causes[..] else {
            panic!("{seed}: {}", summary(&found));
        };
        assert_eq!(drift.effect.effect.id, "instrument_drift", "{seed}");
    }
}

/// Sizes, grids and set-ups as they come: in how many circles all causes are named and no other, and how many of the values are inside
/// two standard uncertainties.
#[test]
#[ignore = "study: 60 diagnoses"]
fn ordinary_circles_are_told_with_their_uncertainties() {
    let (mut right, mut inside, mut all, mut odd) = (0, 0, 0, Vec::new());
    for seed in 100..160 {
        let mut random = generator(seed, 97);
        let sign = |x: f64, is_plus: bool| if is_plus { x } else { -x };
        let wrong = Wrong {
            play_um: std::array::from_fn(|_| random.random_range(1.5..6.0)),
            lag_ms: sign(random.random_range(0.05..0.3), seed % 2 == 0),
            leans_arcsec: sign(random.random_range(2.0..10.0), seed % 3 == 0),
            longer_ppm: sign(random.random_range(8.0..40.0), seed % 5 < 3),
            drift_um_s: 0.0,
        };
        let step_deg = [2.0, 3.0, 5.0][(seed % 3) as usize];
        let start_deg = match seed % 4 {
            0 => 0.0,
            _ => random.random_range(0.0..FRAC_PI_2.to_degrees()),
        };
        let found = found(circle(wrong, (start_deg, step_deg), seed));
        let told = against_truth(&found, wrong);
        match told.len() == 5 && told.iter().all(|own| own.3.is_some()) {
            true => right += 1,
            false => odd.push(format!("{seed} {}", summary(&found))),
        }
        for (_, value, u, truth) in told {
            inside += usize::from(truth.is_some_and(|truth| (value - truth).abs() < 2.0 * u));
            all += 1;
        }
    }
    let line = format!("{right} of 60 circles right; {inside} of {all} values inside; {odd:#?}");
    report(&line);
    assert!(right >= 54, "{line}");
    // Three standard errors of 300 independent values.
    assert!(
        (0.917..0.99).contains(&(inside as f64 / all as f64)),
        "{line}"
    );
}
