//! Ball bars in the plane of X and Y.

use std::f64::consts::TAU;

use nalgebra::Point3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::{Direction, Verification, VerificationKind, VerificationReading};

use crate::counts::Counts;
use crate::{found, generator, length};

pub(crate) const CENTRE_MM: [f64; 2] = [200.0, 180.0];
const RADIUS_MM: f64 = 100.0;
const PER_TURN: usize = 72;
const CYCLES: u32 = 3;

/// A point of the circle: bar angle, sense of rotation, cycle.
#[derive(Clone, Copy)]
struct Stand {
    angle: f64,
    sense: f64,
    cycle: u32,
}

impl Stand {
    fn x_mm(&self) -> f64 {
        CENTRE_MM[0] + RADIUS_MM * self.angle.cos()
    }

    fn y_mm(&self) -> f64 {
        CENTRE_MM[1] + RADIUS_MM * self.angle.sin()
    }
}

fn stands() -> Vec<Stand> {
    let mut stands = Vec::new();
    for cycle in 1..=CYCLES {
        for sense in [1.0, -1.0] {
            for i in 0..PER_TURN {
                let i = if sense > 0.0 { i } else { PER_TURN - i };
                // Half a step from the quadrants, where no axis reverses at a reading.
                let angle = TAU * (i as f64 + 0.5) / PER_TURN as f64;
                stands.push(Stand {
                    angle,
                    sense,
                    cycle,
                });
            }
        }
    }
    stands
}

/// Change of the bar's length when the ball is off by some vector, exactly.
fn lengthened_um(stand: &Stand, off_um: [f64; 2]) -> f64 {
    let (x, y) = (RADIUS_MM * stand.angle.cos(), RADIUS_MM * stand.angle.sin());
    ((x + off_um[0] * 1e-3).hypot(y + off_um[1] * 1e-3) - RADIUS_MM) * 1e3
}

fn table(
    stands: &[Stand],
    off_um: impl Fn(&Stand) -> [f64; 2],
    sigma_um: f64,
    seed: u64,
) -> Verification {
    let mut generator = generator(seed, 4);
    let set_up: [f64; 3] = std::array::from_fn(|_| generator.random_range(-20.0..20.0));
    let rows = stands.iter().enumerate().map(|(row, stand)| {
        let off = off_um(stand);
        let noise: f64 = StandardNormal.sample(&mut generator);
        let value = lengthened_um(stand, [off[0] + set_up[0], off[1] + set_up[1]]);
        VerificationReading {
            time_s: None,
            cycle: stand.cycle,
            direction: if stand.sense > 0.0 {
                Direction::Forward
            } else {
                Direction::Backward
            },
            positions: vec![stand.x_mm(), stand.y_mm(), 0.0],
            value_um: value + set_up[2] + sigma_um * noise,
            line: row + 2,
        }
    });
    in_xy(rows.collect())
}

/// A ball bar in the plane of X and Y, about [`CENTRE_MM`].
pub(crate) fn in_xy(readings: Vec<VerificationReading>) -> Verification {
    Verification {
        name: "DBB in XY".into(),
        kind: VerificationKind::Ballbar {
            ball_mm: Point3::new(0.0, 0.0, 50.0),
            ball_carrier: 2,
            length_is_calibrated: false,
            center_mm: Point3::new(CENTRE_MM[0], CENTRE_MM[1], 50.0),
        },
        u_um: None,
        u_ppm: None,
        readings,
    }
}

pub(crate) fn clean_circle(seed: u64) -> Verification {
    table(&stands(), |_| [0.0; 2], 0.5, seed)
}

/// Y leans against X.
fn squareness(stand: &Stand) -> [f64; 2] {
    [-stand.y_mm(), 0.0]
}

/// X is too long; Y too short does the same.
fn scale(stand: &Stand) -> [f64; 2] {
    [stand.x_mm(), 0.0]
}

/// X stands short where it comes from below.
fn backlash(stand: &Stand) -> [f64; 2] {
    [0.5 * stand.sense * stand.angle.sin().signum(), 0.0]
}

/// Once per 40 mm of X.
fn cyclic(stand: &Stand) -> [f64; 2] {
    [(TAU * stand.x_mm() / 40.0 + 0.7).sin(), 0.0]
}

fn assert_named(seeds: u64) {
    type Form = fn(&Stand) -> [f64; 2];
    let cases: [(&str, usize, Form); 4] = [
        ("squareness_error", 1, squareness),
        ("scale_error", 0, scale),
        ("backlash", 0, backlash),
        ("cyclic_error", 0, cyclic),
    ];
    let stands = stands();
    for lambda in [7.0, 20.0] {
        for (effect, axis, form) in cases {
            let mut counts = Counts::default();
            for seed in 0..seeds {
                let sigma_um = 0.5;
                let trace: Vec<f64> = stands
                    .iter()
                    .map(|s| {
                        let off = form(s);
                        off[0] * s.angle.cos() + off[1] * s.angle.sin()
                    })
                    .collect();
                let size = lambda * sigma_um / length(&beyond_the_set_up(&stands, &trace));
                let off_um = |s: &Stand| form(s).map(|x| size * x);
                counts.add(
                    &found(table(&stands, off_um, sigma_um, seed)),
                    effect,
                    Some(axis),
                );
            }
            counts.assert_named(seeds, &format!("λ {lambda}: ball bar: {effect}"));
        }
    }
}

/// Stiction holds each axis for some millimetres as it turns round, in two cycles of a point for each degree: spikes of 3 µm that fade over
/// 2 mm of arc were clean in 6 of 10 such circles, and other names in 2. Noise of 0.3 µm; without spikes one in 200 raises an alarm.
#[test]
fn reversal_spikes_are_not_clean() {
    let stands = (1..=2).flat_map(|cycle| {
        [1.0, -1.0].into_iter().flat_map(move |sense| {
            (0..360).map(move |i| Stand {
                angle: sense * TAU * (f64::from(i) + 0.5) / 360.0,
                sense,
                cycle,
            })
        })
    });
    let stands: Vec<Stand> = stands.collect();
    for seed in 0..2 {
        let spikes = found(table(&stands, |stand| held_um(stand, 3.0), 0.3, seed));
        assert!(spikes.causes.is_empty(), "seed {seed}");
        let left = spikes.unexplained.unwrap();
        assert!(
            left.varies_with.contains(&"reversal"),
            "seed {seed}: {}",
            left.note
        );
        let none = found(table(&stands, |stand| held_um(stand, 0.0), 0.3, seed));
        assert!(none.unexplained.is_none(), "seed {seed}");
    }
}

/// How far each axis is held outwards after it turned round.
fn held_um(stand: &Stand, size_um: f64) -> [f64; 2] {
    let after = |from: f64| ((stand.angle - from) * stand.sense).rem_euclid(TAU);
    let held = |from: f64| size_um * (-after(from) * RADIUS_MM / 2.0).exp();
    let quarter = TAU / 4.0;
    [
        held(0.0) - held(2.0 * quarter),
        held(quarter) - held(3.0 * quarter),
    ]
}

/// One of each. For a true rate of 99 % one of the eight fails with a probability of 8 %; the seed is
/// fixed.
#[test]
fn each_effect_is_named() {
    assert_named(1);
}

/// For a true rate of 99 % fewer than 9 of 10 come with a probability of 4e-3 for each case; the seeds are
/// fixed.
#[test]
#[ignore = "study: 80 diagnoses"]
fn each_effect_is_named_in_nine_of_ten() {
    assert_named(10);
}

/// What centre and length leave of a trace: means against 1, cos and sin, which are orthogonal over whole
/// turns.
fn beyond_the_set_up(stands: &[Stand], trace: &[f64]) -> Vec<f64> {
    let mut left = trace.to_vec();
    let shapes: [fn(f64) -> f64; 3] = [|_| 1.0, f64::cos, f64::sin];
    for shape in shapes {
        let column: Vec<f64> = stands.iter().map(|s| shape(s.angle)).collect();
        let along: f64 = column.iter().zip(&left).map(|(c, x)| c * x).sum();
        let squares: f64 = column.iter().map(|c| c * c).sum();
        for (x, c) in left.iter_mut().zip(&column) {
            *x -= along / squares * c;
        }
    }
    left
}
