//! The same of points that are tied to rigid bodies, each read once from every station.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_multilateration::Network;
use trueaxis_screening::screen;

use crate::gross_errors::{NOISE, removed};
use crate::world::*;

fn noisy(truth: &Truth, rng: &mut ChaCha8Rng) -> Network {
    let mut network = network(truth, truth.points.clone(), 1, NOISE);
    add_noise(&mut network, truth, rng);
    tied(&network)
}

/// One length of 780 that is wrong by 8 µm: that one is found, alone. It shows with a power of 95 % at
/// least, so that of 40 campaigns more than five are missed with a probability below 2 %.
#[test]
fn one_small_gross_error_of_780_lengths_is_found() {
    let truth = truth(20.0);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let (mut found, mut with_others) = (0, 0);
    for campaign in 0..40 {
        let mut network = noisy(&truth, &mut rng);
        assert_eq!(network.readings.len(), 780);
        let wrong = rng.random_range(0..780);
        network.readings[wrong].length_mm += if campaign % 2 == 0 { 8e-3 } else { -8e-3 };
        let screened = screen(&network, true).unwrap();
        let removed = removed(&screened);
        found += usize::from(removed.contains(&wrong));
        with_others += usize::from(removed.len() > 1);
    }
    println!("{found} of 40 found, {with_others} with others");
    assert!(found >= 35);
    assert!(with_others <= 4);
}

/// A campaign without gross errors loses a length with a probability of 1 %: of 40 more than three are
/// touched with a probability of 1e-3.
#[test]
fn clean_lengths_are_left_alone() {
    let truth = truth(50.0);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut touched = 0;
    for _ in 0..40 {
        let network = noisy(&truth, &mut rng);
        let screened = screen(&network, true).unwrap();
        touched += usize::from(!screened.removed.is_empty() || !screened.jumps.is_empty());
    }
    println!("{touched} of 40 clean campaigns lost a length or were split");
    assert!(touched <= 3);
}

/// A lost count of 50 µm splits the station's occupation where it happened.
#[test]
fn an_interruption_is_found() {
    let truth = truth(50.0);
    let mut network = noisy(&truth, &mut ChaCha8Rng::seed_from_u64(9));
    let per_station = network.readings.len() / 4;
    let first = per_station + per_station / 3;
    for reading in &mut network.readings[first..2 * per_station] {
        reading.length_mm += 0.05;
    }
    let screened = screen(&network, true).unwrap();
    let [jump] = screened.jumps[..] else {
        panic!("{:?}", screened.jumps);
    };
    assert_eq!(jump.station, 1);
    assert!(jump.first_reading.abs_diff(first) <= 3);
    assert!((jump.change_mm - 0.05).abs() < 4.0 * jump.u_mm);
    assert_eq!(screened.solution.dead_paths_after_mm.len(), 1);
}
