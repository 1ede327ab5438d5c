//! Diagnoses through the public verb, of data made by code that shares nothing with it but the format.
//!
//! The fast tests take one case of each effect; the studies (`--ignored`) take as many as the claims in
//! docs/diagnosis-tests.md need. Strengths are given as λ, the length of an effect's trace in standard
//! deviations of an arrival after what the base model absorbs has been taken out.

mod aliases;
mod arcs;
mod at_rest;
mod ball_bar;
mod beyond;
mod blocks;
mod calibrated_lines;
mod circles;
mod clean;
mod coarse;
mod copied;
mod correlated;
mod counts;
mod coupling;
mod curves;
mod exchanged;
mod faults;
mod feeds;
mod gross_errors;
mod instants;
mod iso_run;
mod lines;
mod loosening;
mod machines;
mod made_points;
mod many_gross_errors;
mod many_positions;
mod odd;
mod one_cycle;
mod orders;
mod pass_offsets;
mod paused;
mod periods;
mod point_names;
mod points;
mod rough;
mod settling;
mod several;
mod short_strokes;
mod sides;
mod three_runs;
mod true_gain;
mod two_constants;
mod two_instruments;
mod two_levels;
mod unknown;
mod unseen;

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::{Campaign, Instrument, Verification};
use trueaxis_diagnose::{Diagnosis, Settings, diagnose};
use trueaxis_kinematics::{Axis, Machine};

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

/// What is found in one verification without a calibration.
fn found(verification: Verification) -> Diagnosis {
    found_in(vec![verification])
}

/// The same in several.
fn found_in(verification: Vec<Verification>) -> Diagnosis {
    diagnose(&campaign(verification), &Settings::default()).unwrap()
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

fn generator(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut generator = ChaCha8Rng::seed_from_u64(seed);
    generator.set_stream(stream);
    generator
}

/// Length of a trace.
fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// A line for those who run the tests with `--nocapture`.
#[expect(clippy::print_stderr, reason = "counts of a study")]
fn report(line: &str) {
    eprintln!("{line}");
}
