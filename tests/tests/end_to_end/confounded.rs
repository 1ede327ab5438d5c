//! A machine that moves and a tripod that moves are the same in the lengths, unless targets on the bed are read.

use nalgebra::{DMatrix, DVector, Vector3};
use trueaxis_campaign::Stop;
use trueaxis_diagnose::{Diagnosis, Settings, Verdict, diagnose};
use trueaxis_effects::Level;
use trueaxis_tests::blind::{self, Act, Course, Hidden, Kind};
use trueaxis_tests::in_parallel;

/// What is drawn, its name, and the effect with which it is confounded without the bed.
const PAIRS: [(&str, &str, &str); 4] = [
    ("machine_shift", "machine_shift", "station_jump"),
    ("station_jump", "station_jump", "machine_shift"),
    ("machine_drift", "machine_drift", "station_drift"),
    (
        blind::COMMON_STATION_DRIFT,
        "station_drift",
        "machine_drift",
    ),
];

/// Three targets, five times in each occupation.
fn with_bed() -> Kind {
    Kind::three_axis().with_bed(5)
}

fn hidden(drawn: &str, seed: u64, strength: f64) -> Hidden {
    let hidden = blind::draw(&with_bed(), drawn, seed).unwrap();
    blind::at_strength(&with_bed(), &hidden, seed, strength)
}

fn diagnosed(hidden: &[Hidden], seed: u64) -> Diagnosis {
    let settings = Settings {
        explain_curves: false,
        ..Settings::default()
    };
    diagnose(&blind::campaign(&with_bed(), hidden, seed), &settings).unwrap()
}

/// All that is named in the lengths, alone or with others.
fn named(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let causes = diagnosis.causes.iter();
    let of_lengths = causes.filter(|cause| cause.level == Level::Lengths);
    let ids = of_lengths.flat_map(|cause| {
        let rivals = cause.rival_effects().map(|rival| rival.effect.id);
        std::iter::once(cause.effect.effect.id).chain(rivals)
    });
    ids.collect()
}

/// Diagnoses these campaigns of each pair: in so many at least the hidden one is named, alone or with others, and its
/// other one is not.
fn assert_told_apart(strength: f64, seeds: std::ops::Range<u64>, least: usize) {
    let mut too_few = Vec::new();
    for (drawn, name, confounded) in PAIRS {
        let named = |seed: u64| named(&diagnosed(&[hidden(drawn, seed, strength)], seed));
        let all: Vec<Vec<&str>> = in_parallel(seeds.clone(), named);
        let (told, other): (Vec<_>, Vec<_>) = all
            .iter()
            .partition(|ids| ids.contains(&name) && !ids.contains(&confounded));
        println!(
            "{drawn} at {strength}: {} of {} told from {confounded}; others {other:?}",
            told.len(),
            all.len()
        );
        if told.len() < least {
            too_few.push(drawn);
        }
    }
    assert!(too_few.is_empty(), "λ = {strength}: {too_few:?}");
}

/// The fast part: at λ = 20, of which two thirds tell the two apart in the median.
#[test]
fn bed_targets_tell_the_machine_from_the_tripod() {
    assert_told_apart(20.0, 0..1, 1);
}

/// At λ = 20 all of 20, at λ = 10 at least 18.
#[test]
#[ignore = "study: 160 diagnoses"]
fn bed_targets_tell_the_machine_from_the_tripod_in_twenty_campaigns() {
    assert_told_apart(20.0, 0..20, 20);
    assert_told_apart(10.0, 0..20, 18);
}

/// A bed that stands still raises no alarm: one of six does at a rate of 1.2 % with a probability of 7 %.
#[test]
fn a_bed_at_rest_is_clean() {
    let alarms: Vec<(u64, String)> = in_parallel(0..6_u64, |seed| {
        let verdict = diagnosed(&[], 700 + seed).verdict;
        (verdict != Verdict::Clean).then(|| (seed, verdict.name().to_owned()))
    })
    .into_iter()
    .flatten()
    .collect();
    assert!(alarms.is_empty(), "{alarms:?}");
}

/// The part of an effect that `others`, confounded with it, cannot take.
fn left_by(others: &[Hidden], own: &Hidden, seed: u64) -> f64 {
    let square = |all: &[&Hidden]| {
        let all: Vec<Hidden> = all.iter().map(|h| (*h).clone()).collect();
        blind::strength(&with_bed(), &all, seed).powi(2)
    };
    let product = |a: &Hidden, b: &Hidden| 0.5 * (square(&[a, b]) - square(&[a]) - square(&[b]));
    let count = others.len();
    let gram = DMatrix::from_fn(count, count, |i, j| product(&others[i], &others[j]));
    let right = DVector::from_fn(count, |i, _| product(&others[i], own));
    let taken = right.dot(&(gram.try_inverse().unwrap() * &right));
    (1.0 - taken / square(&[own])).max(0.0).sqrt()
}

/// A shift of the machine in the occupation of a station, and what of it a jump of its tripod cannot take: nothing without
/// the bed, two thirds with it in the median.
#[test]
#[ignore = "study: the figure of the docs"]
fn two_thirds_of_a_shift_tell_it_from_a_jump() {
    let left = |seed: u64| {
        let shift = hidden("machine_shift", seed, 10.0);
        let Course::Jump { instant_s, .. } = shift.course else {
            unreachable!("a shift has an instant");
        };
        let lengths = blind::campaign(&with_bed(), &[], seed).lengths.unwrap();
        let starts = |stop: &Stop| lengths.readings[stop.readings.start].time_s;
        let mut before = lengths.stops.iter().rev();
        let station = before
            .find(|stop| starts(stop) <= instant_s)
            .unwrap()
            .station;
        let jumps: Vec<Hidden> = (0..3)
            .map(|k| Hidden {
                act: Act::Tripod(Vector3::ith(k, 3.0)),
                station: Some(station),
                ..shift.clone()
            })
            .collect();
        left_by(&jumps, &shift, seed)
    };
    let mut all: Vec<f64> = in_parallel(0..20_u64, left);
    all.sort_by(f64::total_cmp);
    println!("{all:.2?}");
    assert!(all[0] > 0.4 && all[10] > 0.6);
}
