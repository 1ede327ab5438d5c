//! Readings that are wrong by themselves, alone or two in a row, and jumps, which are not.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trueaxis_campaign::Verification;
use trueaxis_diagnose::Diagnosis;

use crate::iso_run::table_of_stops;
use crate::{found, generator};

const SIGMA_UM: f64 = 1.0;

/// Five cycles there and back over so many stops, noise of 1 µm, each reading off by `off_um(row)`.
fn run(stops: usize, seed: u64, off_um: impl Fn(usize) -> f64) -> Verification {
    let mut random: ChaCha8Rng = generator(seed, 41);
    let curve: Vec<f64> = (0..stops).map(|_| random.random_range(-9.0..9.0)).collect();
    table_of_stops(5, stops, |row, _, stop| {
        let noise: f64 = StandardNormal.sample(&mut random);
        curve[stop] + off_um(row) + SIGMA_UM * noise
    })
}

fn rows(found: &Diagnosis) -> Vec<usize> {
    found.rejected.iter().map(|r| r.row).collect()
}

/// Two readings in a row that are off by 30 and 60 µm, by as much, or to both sides, wherever they stand: at the ends of a pass, across
/// two of them, at the ends of the table. Nothing else is left out, and nothing is named.
#[test]
fn two_slips_in_a_row_are_left_out() {
    for stops in [5, 9] {
        for (case, errors) in [[30.0, 60.0], [45.0, 45.0], [40.0, -40.0]]
            .iter()
            .enumerate()
        {
            for first in (0..10 * stops - 1).step_by(7) {
                let off = |row: usize| match row.checked_sub(first) {
                    Some(k @ (0 | 1)) => errors[k],
                    _ => 0.0,
                };
                let found = found(run(stops, (100 * case + first) as u64, off));
                let expected = [first + 2, first + 3];
                assert_eq!(
                    rows(&found),
                    expected,
                    "{stops} {errors:?}: {:?}",
                    found.rejected
                );
                assert!(found.causes.is_empty(), "{:?}", found.causes);
            }
        }
    }
}

/// A zero that jumps by 30 µm, two readings before a pass ends or after it began or anywhere, leaves no reading out, if there are
/// three before and after it.
#[test]
fn a_jump_is_no_slip() {
    for stops in [5, 9] {
        for at in (3..10 * stops - 2).step_by(4) {
            let found = found(run(
                stops,
                at as u64,
                |row| if row < at { 0.0 } else { 30.0 },
            ));
            assert!(
                found.rejected.is_empty(),
                "{stops} {at}: {:?}",
                found.rejected
            );
            assert!(found.verdict.is_misfit(), "{stops} {at}");
        }
    }
}

/// In passes of three readings two that are off look like one that is off the other way.
#[test]
fn two_of_three_are_told_from_the_third() {
    for first in [0, 1, 7, 12, 15, 28] {
        let off = |row: usize| {
            if row == first || row == first + 1 {
                300.0
            } else {
                0.0
            }
        };
        let found = found(run(3, first as u64, off));
        let rows = rows(&found);
        assert!(
            rows.iter().all(|row| [first + 2, first + 3].contains(row)),
            "{rows:?}"
        );
    }
}
