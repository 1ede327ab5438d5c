//! ISO 230-2, again: as the rows of a spreadsheet, with the standard deviation from the differences of all pairs.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trueaxis_campaign::Direction;
use trueaxis_compensate::Positioning;

const POSITIONS: usize = 11;

/// Cells of a row: `x̄`, `x̄ + 2 s`, `x̄ - 2 s`, `4 s`. `s² = Σ_{i<j} (x_i - x_j)² / (n (n - 1))`.
fn row(passes: &[f64]) -> [f64; 4] {
    let n = passes.len();
    let mut pairs = 0.0;
    for i in 0..n {
        for j in 0..i {
            pairs += (passes[i] - passes[j]) * (passes[i] - passes[j]);
        }
    }
    let s = (pairs / (n * (n - 1)) as f64).sqrt();
    let mean = passes.iter().sum::<f64>() / n as f64;
    [mean, mean + 2.0 * s, mean - 2.0 * s, 4.0 * s]
}

fn largest(column: impl Iterator<Item = f64>) -> f64 {
    column.fold(f64::NEG_INFINITY, f64::max)
}

fn smallest(column: impl Iterator<Item = f64>) -> f64 {
    -largest(column.map(|x| -x))
}

/// Five to seven passes a side, in the order of a test that goes to and fro; the zero of the instrument is in none.
#[test]
fn quantities_are_those_of_a_spreadsheet() {
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let cycles = 5 + usize::try_from(seed % 3).unwrap();
        let mut passes = vec![[Vec::new(), Vec::new()]; POSITIONS];
        let mut measured = Vec::new();
        for _ in 0..cycles {
            for (side, direction) in [Direction::Forward, Direction::Backward]
                .into_iter()
                .enumerate()
            {
                for k in 0..POSITIONS {
                    let k = if side == 0 { k } else { POSITIONS - 1 - k };
                    let x = 30.0 * (k as f64 / 4.0).sin()
                        + 2.0 * side as f64
                        + 3.0 * rng.random::<f64>();
                    passes[k][side].push(x);
                    measured.push((37.3 * k as f64 - 50.0, direction, x + 17.0));
                }
            }
        }
        let found = Positioning::new(&measured);
        let rows: Vec<[[f64; 4]; 2]> = passes.iter().map(|[f, b]| [row(f), row(b)]).collect();
        let check = |name: &str, found: f64, expected: f64| {
            assert!(
                (found - expected).abs() < 1e-9,
                "{name}: {found}, expected {expected}"
            );
        };
        for side in 0..2 {
            let column = |c: usize| rows.iter().map(move |row| row[side][c]);
            let own = found.sides[side].unwrap();
            check("E", own.e_um, largest(column(0)) - smallest(column(0)));
            check("R", own.r_um.unwrap(), largest(column(3)));
            check(
                "A",
                own.a_um.unwrap(),
                largest(column(1)) - smallest(column(2)),
            );
        }
        let both = found.sides[2].unwrap();
        let of_both = |c: usize| rows.iter().flat_map(move |row| [row[0][c], row[1][c]]);
        check("E", both.e_um, largest(of_both(0)) - smallest(of_both(0)));
        check(
            "A",
            both.a_um.unwrap(),
            largest(of_both(1)) - smallest(of_both(2)),
        );
        let reversal = |row: &[[f64; 4]; 2]| row[0][0] - row[1][0];
        let repeatability = |row: &[[f64; 4]; 2]| {
            let sum = 0.5 * (row[0][3] + row[1][3]) + reversal(row).abs();
            largest([sum, row[0][3], row[1][3]].into_iter())
        };
        check(
            "R",
            both.r_um.unwrap(),
            largest(rows.iter().map(repeatability)),
        );
        check(
            "B",
            found.b_um.unwrap(),
            largest(rows.iter().map(|row| reversal(row).abs())),
        );
        let mean = rows.iter().map(reversal).sum::<f64>() / POSITIONS as f64;
        check("mean B", found.mean_b_um.unwrap(), mean);
        let means = || rows.iter().map(|row| 0.5 * (row[0][0] + row[1][0]));
        check(
            "M",
            found.m_um.unwrap(),
            largest(means()) - smallest(means()),
        );
        assert_eq!((found.passes, found.is_short), (cycles, false));
    }
}
