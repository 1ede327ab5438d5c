//! What a verification leaves open whatever the machine does: the columns of its base model.
//!
//! | data | without a calibration | with one |
//! | --- | --- | --- |
//! | positioning | the mean curve: a free value at each commanded position, and the zero of each line | the zero of each line |
//! | ball bar | set-up: offset of the centre (3), length of the bar (1) | the same |
//!
//! A *line* is the readings with the other axes at the same positions; the interferometer is set to zero for each.
//! The mean curve is that over all cycles, directions and lines: it absorbs the positioning error of the axis, so
//! scale and cyclic error, but not differences between directions, cycles or lines. The set-up of a ball bar absorbs
//! a constant and one wave per turn: scale errors common to the axes, not squareness.

use std::cmp::Ordering;

use trueaxis_campaign::VerificationKind;
use trueaxis_predict::{ball_bar_set_up, positioning_lines};

use crate::verification::arrivals::{Arrival, groups_in_order};
use crate::verification::comparison::Comparison;

/// The columns, µm per unit.
pub(crate) fn base_columns(comparison: &Comparison<'_>, calibrated: bool) -> Vec<Vec<f64>> {
    match comparison.kind {
        VerificationKind::Positioning { .. } => {
            let mut columns = Vec::new();
            if !calibrated {
                // First, since they have no rows in common: thousands of them take no time.
                columns.extend(indicators(&places(comparison)));
            }
            columns.extend(indicators(&lines(comparison)));
            columns
        }
        VerificationKind::Ballbar { .. } => set_up(comparison),
    }
}

/// What the base absorbs, as a phrase.
pub(crate) fn absorbed(comparison: &Comparison<'_>, calibrated: bool) -> &'static str {
    match (comparison.kind, calibrated) {
        (VerificationKind::Positioning { .. }, false) => {
            "the mean curve over cycles and directions, which stands for the machine as long as there is no calibration"
        }
        (VerificationKind::Positioning { .. }, true) => {
            "the zero of the interferometer or the uncertainty of the calibration"
        }
        (VerificationKind::Ballbar { .. }, false) => {
            "the set-up of the ball bar: the place of its centre and its length"
        }
        (VerificationKind::Ballbar { .. }, true) => {
            "the set-up of the ball bar or the uncertainty of the calibration"
        }
    }
}

/// Offset of the centre along x, y, z and length of the bar.
pub(crate) fn set_up(comparison: &Comparison<'_>) -> Vec<Vec<f64>> {
    let towards: Vec<_> = comparison.points.iter().map(|p| -p.along).collect();
    ball_bar_set_up(&towards)
}

/// For each arrival the index of its line.
pub(crate) fn lines(comparison: &Comparison<'_>) -> Vec<usize> {
    let positions = comparison.arrivals.iter().map(|a| a.positions.as_slice());
    positioning_lines(comparison.axis(), positions)
}

/// For each arrival the index of the commanded position of the measured axis.
pub(crate) fn places(comparison: &Comparison<'_>) -> Vec<usize> {
    let measured = comparison.axis();
    numbered(comparison, |a| vec![a.positions[measured]])
}

/// For each arrival the index of its commanded positions of all axes.
pub(crate) fn stands(comparison: &Comparison<'_>) -> Vec<usize> {
    numbered(comparison, |a| a.positions.clone())
}

/// For each arrival the index of its commanded positions and direction; the end of a circle is apart from its start.
pub(crate) fn cells(comparison: &Comparison<'_>) -> Vec<usize> {
    let key = |a: &Arrival| {
        let end = f64::from(u8::from(a.closes_circle));
        [&a.positions[..], &[a.direction, end]].concat()
    };
    numbered(comparison, key)
}

/// For each arrival the index of its cycle.
pub(crate) fn cycles(comparison: &Comparison<'_>) -> Vec<usize> {
    numbered(comparison, |a| vec![f64::from(a.cycle)])
}

/// For each arrival the index of its cycle among consecutive ones, whatever their numbers.
pub(crate) fn runs_of_cycles(comparison: &Comparison<'_>) -> Vec<usize> {
    groups_in_order(&comparison.arrivals, |a, b| a.cycle == b.cycle)
}

/// For each arrival the index of its cycle and direction, forward first.
pub(crate) fn passes(comparison: &Comparison<'_>) -> Vec<usize> {
    numbered(comparison, |a| vec![f64::from(a.cycle), -a.direction])
}

/// Numbers the different values of a key in ascending order.
fn numbered(comparison: &Comparison<'_>, key: impl Fn(&Arrival) -> Vec<f64>) -> Vec<usize> {
    let keys: Vec<Vec<f64>> = comparison.arrivals.iter().map(key).collect();
    let order = |a: &Vec<f64>, b: &Vec<f64>| {
        let pairs = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
        pairs.fold(Ordering::Equal, Ordering::then)
    };
    let mut distinct = keys.clone();
    distinct.sort_by(order);
    distinct.dedup_by(|a, b| order(a, b).is_eq());
    let number = |key| {
        distinct
            .binary_search_by(|other| order(other, key))
            .unwrap_or_default()
    };
    keys.iter().map(number).collect()
}

/// How many different indices there are, counted from 0.
pub(crate) fn count(numbers: &[usize]) -> usize {
    numbers.iter().max().map_or(0, |last| last + 1)
}

/// How often each index is there.
pub(crate) fn sizes(numbers: &[usize]) -> Vec<usize> {
    let mut sizes = vec![0; count(numbers)];
    numbers.iter().for_each(|&number| sizes[number] += 1);
    sizes
}

/// Subtracts from values the location (mean, median) of those with the same index.
pub(crate) fn less_location(
    x: &mut [f64],
    numbers: &[usize],
    location: impl Fn(&mut [f64]) -> f64,
) {
    let mut of_numbers: Vec<Vec<f64>> = vec![Vec::new(); count(numbers)];
    for (x, &number) in x.iter().zip(numbers) {
        of_numbers[number].push(*x);
    }
    let locations: Vec<f64> = of_numbers.iter_mut().map(|own| location(own)).collect();
    for (x, &number) in x.iter_mut().zip(numbers) {
        *x -= locations[number];
    }
}

/// One column for each index.
pub(crate) fn indicators(numbers: &[usize]) -> Vec<Vec<f64>> {
    let mut columns = vec![vec![0.0; numbers.len()]; count(numbers)];
    for (row, &number) in numbers.iter().enumerate() {
        columns[number][row] = 1.0;
    }
    columns
}

/// The product of two columns, row by row.
pub(crate) fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}
