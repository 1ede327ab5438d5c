//! Readings that jump between two levels and were taken for readings in air that stirs.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Verification;
use trueaxis_diagnose::Verdict;

use crate::iso_run::table_of_stops;
use crate::{found, generator};

/// Five cycles over five stops: ±45 µm, each kept for eight readings in the mean; noise of 10 µm.
fn jumping(seed: u64) -> Verification {
    let mut random: ChaCha8Rng = generator(seed, 140);
    let mut level = 45.0;
    table_of_stops(5, 5, &mut |_, _, _| {
        if random.random_range(0.0..1.0) < 0.125 {
            level = -level;
        }
        let noise: f64 = StandardNormal.sample(&mut random);
        level + 10.0 * noise
    })
}

/// The same stops in noise with this correlation.
fn stirred(seed: u64, correlation: f64, stops: usize) -> Verification {
    let mut random: ChaCha8Rng = generator(seed, 141);
    let mut noise: f64 = StandardNormal.sample(&mut random);
    table_of_stops(5, stops, &mut |_, _, _| {
        let read = noise;
        let next: f64 = StandardNormal.sample(&mut random);
        noise = correlation * noise + (1.0 - correlation * correlation).sqrt() * next;
        read
    })
}

fn says_levels(table: Verification) -> (bool, Verdict) {
    let found = found(table);
    let mut unexplained = found.unexplained.iter();
    // Levels that are three standard deviations apart are 70 % of the squares.
    let says = unexplained.any(|own| own.note.contains("two levels") && own.share > 0.6);
    (says, found.verdict)
}

/// Most of 12 show something else, a drift or a jump; of three that show nothing else, two have levels now, and one is clean.
#[test]
fn jumps_between_two_levels_are_not_clean() {
    let verdicts = (0..12).map(|seed| says_levels(jumping(seed)));
    let verdicts: Vec<(bool, Verdict)> = verdicts.collect();
    let said = verdicts.iter().filter(|(says, _)| *says).count();
    crate::report(&format!("{verdicts:?}"));
    assert!(said >= 2, "{said} of 12");
    let clean = verdicts.iter().filter(|(_, v)| *v == Verdict::Clean);
    assert!(clean.count() <= 1);
}

/// At a level of 0.5 % more than one of 30 has two levels with a probability of 0.01.
#[test]
fn air_that_stirs_has_no_levels() {
    let seeds = 0..30;
    let levels = seeds.filter(|&seed| says_levels(stirred(seed, 0.6, 5)).0);
    let levels = levels.count();
    assert!(levels <= 1, "{levels} of 30");
}

/// `cargo test -p trueaxis-diagnose --test diagnose two_levels -- --ignored --nocapture`
#[test]
#[ignore = "a study"]
fn counts_of_levels() {
    let clean = (100..200).filter(|&seed| says_levels(jumping(seed)).1 == Verdict::Clean);
    crate::report(&format!("jumping: {} of 100 clean", clean.count()));
    for (correlation, stops) in [
        (0.0, 5),
        (0.5, 5),
        (0.65, 5),
        (0.8, 5),
        (0.5, 11),
        (0.8, 11),
    ] {
        let all = (1000..1300).map(|seed| says_levels(stirred(seed, correlation, stops)));
        let all: Vec<(bool, Verdict)> = all.collect();
        let levels = all.iter().filter(|(says, _)| *says).count();
        let clean = all.iter().filter(|(_, v)| *v == Verdict::Clean).count();
        crate::report(&format!(
            "correlation {correlation}, {stops} stops: {levels} levels, {clean} clean of 300"
        ));
    }
}
