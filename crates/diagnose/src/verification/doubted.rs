//! Readings that are far off, however many they are: the least squares of a table in which one in ten is wrong hide them all.
//!
//! What a model leaves is taken less the median of each position and side and of each pass (median polish; Tukey 1977, ch. 11), which
//! wrong readings do not move as long as they are fewer than the others, and compared with 1.4826 times the median of its sizes, the
//! standard deviation of normal noise.

use crate::verification::base::{cells, count, passes};
use crate::verification::comparison::Comparison;
use crate::verification::gross_errors::{MOST_IN_A_ROW, most};
use crate::verification::problem::Problem;
use crate::verification::resolution::resolution_um;
use crate::{Unexplained, selection::Projection};
use trueaxis_effects::Level;

/// Standard deviations from which on a reading is far off: as many as a slip has at least.
const FAR: f64 = 8.0;

/// Standard deviation of normal noise for a unit of its median size.
const OF_MEDIAN: f64 = 1.4826;

/// Medians of positions and of passes in turn.
const SWEEPS: usize = 4;

/// Passes of more readings have an offset of their own, as in [`super::noise_floor::scatter`].
const SHORT_PASS: usize = 2;

/// Lines of the table that are named.
const NAMED: usize = 6;

/// The arrivals that are far off in what is left of all, and by how much, µm, in their order.
pub(crate) fn far_off(comparison: &Comparison<'_>, left_um: &[f64]) -> Vec<(usize, f64)> {
    let (cells, passes) = (cells(comparison), passes(comparison));
    let longest = sizes(&passes).into_iter().max().unwrap_or_default();
    let mut off = left_um[..cells.len()].to_vec();
    for _ in 0..SWEEPS {
        less_medians(&mut off, &cells);
        if longest > SHORT_PASS {
            less_medians(&mut off, &passes);
        }
    }
    let values = comparison.arrivals.iter().map(|a| a.value_um);
    let digit_um = 12.0_f64.sqrt() * resolution_um(values).unwrap_or_default();
    let mut lengths: Vec<f64> = off.iter().map(|x| x.abs()).collect();
    lengths.sort_by(f64::total_cmp);
    // Each median leaves nothing of the reading that it is.
    let rest = &lengths[count(&cells).min(lengths.len())..];
    let Some(middle) = rest.get(rest.len() / 2) else {
        return Vec::new();
    };
    let far_um = FAR * (OF_MEDIAN * middle).max(digit_um);
    let all = off.into_iter().enumerate();
    all.filter(|(_, off)| off.abs() > far_um).collect()
}

/// How many mistakes make what is far off, where no more than two follow each other: of two readings at a position a mistake of one puts
/// both off. Where three or more follow each other something else is behind it.
pub(crate) fn mistakes(comparison: &Comparison<'_>, far: &[(usize, f64)]) -> f64 {
    let cells = cells(comparison);
    let sizes = sizes(&cells);
    let rows = far.chunk_by(|a, b| a.0 + 1 == b.0);
    let rows = rows.filter(|row| row.len() <= MOST_IN_A_ROW);
    let parts = rows.map(|row| match sizes[cells[row[0].0]] {
        2 => 0.5,
        _ => 1.0,
    });
    parts.sum()
}

/// Many readings that are far off in what a model leaves, which is no longer the noise of the others.
pub(crate) fn doubted(problem: &Problem<'_>, after: &Projection) -> Option<Unexplained> {
    let comparison = problem.comparison;
    let readings = problem.readings();
    let left = after.residuals.iter().map(|r| r * problem.sigma_um);
    let far = far_off(comparison, &left.collect::<Vec<f64>>());
    if mistakes(comparison, &far) <= most(readings) as f64 {
        return None;
    }
    let sizes = || far.iter().map(|(_, off)| off.abs());
    let (least, largest) = (
        sizes().fold(f64::INFINITY, f64::min),
        sizes().fold(0.0, f64::max),
    );
    let lines = far.iter().take(NAMED);
    let lines: Vec<String> = lines
        .map(|(row, _)| comparison.arrivals[*row].line.to_string())
        .collect();
    let more = if far.len() > NAMED { " and others" } else { "" };
    Some(Unexplained {
        level: Level::Verification,
        data: String::new(),
        rms_um: (sizes().map(|off| off * off).sum::<f64>() / readings as f64).sqrt(),
        share: 0.0,
        is_of_tests: false,
        varies_with: vec!["reading"],
        note: format!(
            "{} of {readings} readings are off by {least:.1} to {largest:.1} µm against the others of their position, too many to leave out: \
             lines {}{more}",
            far.len(),
            lines.join(", ")
        ),
    })
}

/// How many there are of each number.
fn sizes(numbers: &[usize]) -> Vec<usize> {
    let mut sizes = vec![0; count(numbers)];
    numbers.iter().for_each(|&number| sizes[number] += 1);
    sizes
}

/// Takes the median of each group out.
fn less_medians(x: &mut [f64], groups: &[usize]) {
    let mut of_groups: Vec<Vec<f64>> = vec![Vec::new(); count(groups)];
    for (x, &group) in x.iter().zip(groups) {
        of_groups[group].push(*x);
    }
    let medians = of_groups.into_iter().map(|mut own| {
        own.sort_by(f64::total_cmp);
        let middle = own.len() / 2;
        match own.len() {
            0 => 0.0,
            n if n % 2 == 0 => 0.5 * (own[middle - 1] + own[middle]),
            _ => own[middle],
        }
    });
    let medians: Vec<f64> = medians.collect();
    for (x, &group) in x.iter_mut().zip(groups) {
        *x -= medians[group];
    }
}
