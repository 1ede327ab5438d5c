//! Readings far off, however many they are: least squares over a table with one in ten wrong hide them all.
//!
//! From what a model leaves, the median of each position and side and of each pass is subtracted (median polish;
//! Tukey 1977, ch. 11), which wrong readings do not move as long as they are fewer than the others; the rest is
//! compared with the standard deviation of normal noise with the same median size ([`sigma_um`]).

use trueaxis_effects::Level;
use trueaxis_selection::Projection;

use crate::Unexplained;
use crate::engine::{ACCIDENTS, first_lines, most};
use crate::numbers::{distinct, extremes};
use crate::verification::base::{cells, count, less_location, passes, sizes};
use crate::verification::comparison::Comparison;
use crate::verification::gross_errors::MOST_IN_A_ROW;
use crate::verification::noise_floor::SHORT_PASS;
use crate::verification::problem::Problem;

/// Standard deviations from which on a reading is far off: the least gross error.
pub(crate) const FAR: f64 = 8.0;

/// Standard deviation of normal noise for a unit of its median size.
pub(crate) const OF_MEDIAN: f64 = 1.4826;

/// How often the medians of positions and of passes are subtracted in turn.
const SWEEPS: usize = 4;

/// The arrivals that are far off in what is left of all, and by how much, µm, in their order.
pub(crate) fn far_off(comparison: &Comparison<'_>, left_um: &[f64]) -> Vec<(usize, f64)> {
    let mut off = left_um[..comparison.arrivals.len()].to_vec();
    let Some(sigma_um) = sigma_um(&mut off, &cells(comparison), &passes(comparison)) else {
        return Vec::new();
    };
    let digit_um = 12.0_f64.sqrt() * comparison.resolution_um().unwrap_or_default();
    let far_um = FAR * sigma_um.max(digit_um);
    let all = off.into_iter().enumerate();
    all.filter(|(_, off)| off.abs() > far_um).collect()
}

/// Subtracts the medians of cells, and of passes where any is longer than [`SHORT_PASS`], from readings and returns
/// the standard deviation of their noise; `None` where nothing remains to determine it.
///
/// ```text
/// s = 1.4826 median |e| √(m/ν)
/// ```
///
/// `ν` is the number of readings less the medians. The median of an odd number of readings is one of them and leaves
/// nothing of it, so that many of the smallest sizes are not counted; `m` are. That of an even number leaves
/// something of all. A pass and a cell on the same side have a constant in common.
fn sigma_um(off: &mut [f64], cells: &[usize], passes: &[usize]) -> Option<f64> {
    let longest = sizes(passes).into_iter().max()?;
    let mut groups = vec![cells];
    let mut common = 0;
    if longest > SHORT_PASS {
        groups.push(passes);
        common = sides(cells, passes);
    }
    for _ in 0..SWEEPS {
        groups
            .iter()
            .for_each(|group| less_location(off, group, median));
    }
    let sizes: Vec<usize> = groups.iter().flat_map(|group| sizes(group)).collect();
    let freedom = (off.len() + common).checked_sub(sizes.len())?;
    let odd = sizes.iter().filter(|size| *size % 2 == 1).count();
    let mut lengths: Vec<f64> = off.iter().map(|x| x.abs()).collect();
    lengths.sort_by(f64::total_cmp);
    let counted = lengths.get(odd.saturating_sub(common)..)?;
    let middle = counted.get(counted.len() / 2).filter(|_| freedom > 0)?;
    Some(OF_MEDIAN * middle * (counted.len() as f64 / freedom as f64).sqrt())
}

/// How many mistakes explain what is far off, where at most two are consecutive: of two readings at a position a
/// mistake in one puts both off. Three or more consecutive ones have another reason.
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

/// Many readings that are far off in what a model leaves, which is then no longer the noise of the others.
pub(crate) fn doubted(problem: &Problem<'_>, after: &Projection) -> Option<Unexplained> {
    let comparison = problem.comparison;
    let readings = problem.readings();
    let far = far_off(comparison, &problem.um(&after.residuals));
    if mistakes(comparison, &far) <= most(ACCIDENTS, readings) as f64 {
        return None;
    }
    let sizes = || far.iter().map(|(_, off)| off.abs());
    let [least, largest] = extremes(sizes());
    let lines = far.iter().map(|(row, _)| comparison.arrivals[*row].line);
    let rms_um = (sizes().map(|off| off * off).sum::<f64>() / readings as f64).sqrt();
    let note = format!(
        "{} of {readings} readings are off by {least:.1} to {largest:.1} µm against the others of their position, too many to leave out: \
         {}",
        far.len(),
        first_lines(lines)
    );
    let left = Unexplained::new(Level::Verification, rms_um, vec!["reading"], note);
    Some(left)
}

/// Number of sides: sets of cells that no pass connects.
fn sides(cells: &[usize], passes: &[usize]) -> usize {
    let mut side_of_cell: Vec<usize> = (0..count(cells)).collect();
    let mut cell_of_pass = vec![None; count(passes)];
    for (&cell, &pass) in cells.iter().zip(passes) {
        let first = *cell_of_pass[pass].get_or_insert(cell);
        let (own, other) = (side_of_cell[cell], side_of_cell[first]);
        if own != other {
            let sides = side_of_cell.iter_mut().filter(|side| **side == own);
            sides.for_each(|side| *side = other);
        }
    }
    distinct(side_of_cell).len()
}

/// The median; of an even number the mean of the two in the middle.
fn median(own: &mut [f64]) -> f64 {
    own.sort_by(f64::total_cmp);
    let middle = own.len() / 2;
    match own.len() {
        0 => 0.0,
        n if n % 2 == 0 => 0.5 * (own[middle - 1] + own[middle]),
        _ => own[middle],
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Noise of 1 µm in all kinds of tables: positions read an even or odd number of times, passes of one to 33. The
    /// mean of 200 is right within a quarter: 0.8 where positions are read four times, 1.15 where three times.
    #[test]
    fn noise_is_told_whatever_the_table() {
        let layouts = [
            (9, 2),
            (33, 2),
            (9, 3),
            (17, 3),
            (9, 4),
            (9, 5),
            (3, 16),
            (3, 17),
            (4, 13),
            (5, 10),
            (1, 16),
            (2, 50),
        ];
        let mut random = ChaCha8Rng::seed_from_u64(63);
        for (stops, cycles) in layouts {
            for sides in [1, 2] {
                let rows = 0..stops * cycles * sides;
                let pass = |row: usize| row / stops;
                let cells: Vec<usize> = rows
                    .clone()
                    .map(|row| pass(row) % sides * stops + row % stops)
                    .collect();
                let passes: Vec<usize> = rows.clone().map(pass).collect();
                let of_table = |_| {
                    let mut noise: Vec<f64> = rows
                        .clone()
                        .map(|_| StandardNormal.sample(&mut random))
                        .collect();
                    sigma_um(&mut noise, &cells, &passes).unwrap()
                };
                let mean = (0..200).map(of_table).sum::<f64>() / 200.0;
                assert!(
                    (mean - 1.0).abs() < 0.25,
                    "{stops} {cycles} {sides}: {mean}"
                );
            }
        }
    }
}
